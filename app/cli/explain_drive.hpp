// The drives' own codes in words, as their profiles have them: `gantry explain std402ec:8611`, `amd530b:213F.4`,
// `std402ec` for all of a drive.
//   if (names_drive(word, machine_file)) return explain_drive(word, machine_file, json);
#pragma once
#include <string>
#include <vector>

namespace gantry::cli {

/// Is `word` the name of a drive's profile, or anything before a colon?
bool names_drive(const std::string& word, const std::string& machine_file);

/// Shows it, and gives the exit code: usage where nobody knows the drive or the code.
int explain_drive(const std::string& word, const std::string& machine_file, bool json);

/// Names of the drives whose profiles lie beside the machine file's folder, in order.
std::vector<std::string> drive_names(const std::string& machine_file);

}  // namespace gantry::cli
