#include "app/cli/explain_drive.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/cli/terminal.hpp"
#include "app/cli/verbs.hpp"
#include "config/drive.hpp"
#include "config/yaml.hpp"
#include "core/near_word.hpp"
#include "devices/profiles/map_pdos.hpp"

namespace gantry::cli {
namespace {

namespace fs = std::filesystem;

/// What the program knows of one code of a drive.
struct Entry {
  std::string code;  ///< "8611", "213F.4": what stands behind the colon
  std::string where;
  std::string kind, text, remedy, section;
  std::optional<Fault> becomes;  ///< none: 603Fh beside it is not stated
  bool power_cycle = false;
};

fs::path profiles_of(const std::string& machine_file) {
  return config::profiles_beside(fs::path(machine_file).parent_path().string(), "drives");
}

std::string lower(std::string word) {
  std::transform(word.begin(), word.end(), word.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return word;
}

std::string_view kind_text(config::DriveErrorKind kind) {
  switch (kind) {
    case config::DriveErrorKind::Fault: return "fault";
    case config::DriveErrorKind::Warning: return "warning";
    case config::DriveErrorKind::EmergencyInput: return "emergency stop input";
    case config::DriveErrorKind::Limit: return "limit switch";
    case config::DriveErrorKind::Undervoltage: return "under-voltage";
    case config::DriveErrorKind::PowerCycle: return "fault that only a power cycle clears";
  }
  return "";
}

const config::DriveErrorRow* row_of(const config::DriveFacts& drive, std::uint32_t code) {
  for (const auto& row : drive.errors)
    if (row.code == code) return &row;
  return nullptr;
}

std::vector<Entry> entries_of(const config::StationProfile& profile) {
  std::vector<Entry> all;
  if (!profile.drive) return all;
  for (const auto& row : profile.drive->errors)
    all.push_back({fmt::format("{:04X}", row.code), fmt::format("603Fh = {:04X}h", row.code),
                   std::string(kind_text(row.kind)), row.text, row.remedy, row.section, devices::meaning(row).fault,
                   row.kind == config::DriveErrorKind::PowerCycle});
  for (const auto& row : profile.drive->alarm_bits) {
    const auto* beside = row.code != 0 ? row_of(*profile.drive, row.code) : nullptr;
    const std::string code = fmt::format("{:04X}{}.{}", row.address.index,
                                         row.address.sub != 0 ? fmt::format(":{}", row.address.sub) : "", row.bit);
    all.push_back({code,
                   fmt::format("bit {} of {}{}", row.bit, config::to_text(row.address),
                               row.code != 0 ? fmt::format(", with 603Fh = {:04X}h", row.code) : ""),
                   beside != nullptr ? std::string(kind_text(beside->kind)) : "", row.text, row.remedy, row.section,
                   beside != nullptr ? std::optional(devices::meaning(*beside).fault) : std::nullopt,
                   beside != nullptr && beside->kind == config::DriveErrorKind::PowerCycle});
  }
  return all;
}

/// "0x8611", "8611h", "8611" and "64" are one way of writing: hexadecimal digits, at least four. "213F.04" is 213F.4.
std::string canonical(std::string word) {
  word = lower(std::move(word));
  std::string bit;
  if (const auto dot = word.find('.'); dot != std::string::npos) {
    bit = word.substr(dot + 1);
    word.resize(dot);
    unsigned number = 0;
    const auto read = std::from_chars(bit.data(), bit.data() + bit.size(), number);
    if (read.ec == std::errc{} && read.ptr == bit.data() + bit.size()) bit = std::to_string(number);
    bit.insert(0, ".");
  }
  if (word.starts_with("0x")) word.erase(0, 2);
  if (word.size() > 1 && word.back() == 'h') word.pop_back();
  std::uint32_t number = 0;
  const auto read = std::from_chars(word.data(), word.data() + word.size(), number, 16);
  if (!word.empty() && read.ec == std::errc{} && read.ptr == word.data() + word.size())
    word = fmt::format("{:04X}", number);
  return word + bit;
}

std::string section_text(const config::StationProfile& profile, const Entry& e) {
  return e.section.empty() ? fmt::format("assumed: {} states it in no section", profile.manual)
                           : fmt::format("{}, section {}", profile.manual, e.section);
}

std::string becomes_text(const Entry& e) {
  if (!e.becomes) return "not stated: 603Fh tells what the drive reports beside it";
  const FaultInfo& f = info(*e.becomes);
  return fmt::format("{} {}: {}{}", std::string_view(code(f.fault)), f.name, f.text,
                     e.power_cycle ? "; cleared by a power cycle of the drive" : "");
}

nlohmann::ordered_json to_json(const config::StationProfile& profile, const Entry& e) {
  nlohmann::ordered_json document{{"code", profile.name + ":" + e.code},
                                  {"drive", profile.title},
                                  {"shown_as", e.where},
                                  {"kind", nullptr},
                                  {"text", e.text},
                                  {"remedy", e.remedy},
                                  {"manual", profile.manual},
                                  {"section", nullptr},
                                  {"assumed", e.section.empty()},
                                  {"becomes", nullptr}};
  if (!e.kind.empty()) document["kind"] = e.kind;
  if (!e.section.empty()) document["section"] = e.section;
  if (e.becomes) document["becomes"] = {{"code", std::string_view(code(*e.becomes))}, {"name", info(*e.becomes).name}};
  return document;
}

void list(const config::StationProfile& profile, const std::vector<Entry>& entries, bool json) {
  if (json) {
    auto all = nlohmann::ordered_json::array();
    for (const Entry& e : entries) all.push_back(to_json(profile, e));
    show_document("ok", {{"codes", all}});
    return;
  }
  print_text("{} ({})\n", profile.title, profile.manual);
  for (const Entry& e : entries)
    print_text("{:<16} {}  {:<42} {}\n", profile.name + ":" + e.code,
               e.becomes ? std::string_view(code(*e.becomes)) : "    ", e.text,
               e.section.empty() ? "assumed" : "section " + e.section);
}

}  // namespace

std::vector<std::string> drive_names(const std::string& machine_file) {
  return config::yaml_files_in(profiles_of(machine_file).string());
}

bool names_drive(const std::string& word, const std::string& machine_file) {
  if (word.find(':') != std::string::npos) return true;
  const auto names = drive_names(machine_file);
  return std::find(names.begin(), names.end(), lower(word)) != names.end();
}

int explain_drive(const std::string& word, const std::string& machine_file, bool json) {
  const auto colon = word.find(':');
  const std::string drive = lower(word.substr(0, colon));
  const auto names = drive_names(machine_file);
  if (std::find(names.begin(), names.end(), drive) == names.end()) {
    const std::vector<std::string_view> known(names.begin(), names.end());
    return show(
        Error{Fault::Usage,
              names.empty() ? fmt::format("there is no drive's profile in {}; --machine names a file beside them",
                                          profiles_of(machine_file).string())
                            : fmt::format("there is no drive '{}' in {}; {}", drive, profiles_of(machine_file).string(),
                                          did_you_mean(drive, known)),
              ""},
        json);
  }
  const auto profile = config::load_profile((profiles_of(machine_file) / (drive + ".yaml")).string());
  if (!profile) return show(profile.error(), json);
  const std::vector<Entry> entries = entries_of(*profile);
  if (colon == std::string::npos || colon + 1 == word.size()) {
    list(*profile, entries, json);
    return static_cast<int>(ExitCode::Done);
  }
  const std::string wanted = canonical(word.substr(colon + 1));
  const auto found = std::find_if(entries.begin(), entries.end(), [&](const Entry& e) { return e.code == wanted; });
  if (found == entries.end()) {
    std::vector<std::string_view> known;
    for (const Entry& e : entries) known.push_back(e.code);
    const std::string object = wanted.substr(0, wanted.find('.')) + ".";
    std::vector<std::string_view> bits;  // of an object whose bits are the codes
    for (const std::string_view code : known)
      if (code.starts_with(object)) bits.push_back(code);
    const auto meant =
        std::ranges::find_if(known, [&](std::string_view code) { return bits.empty() && slip_of(wanted, code); });
    const std::string others = bits.empty() ? fmt::format("it lists {}", fmt::join(known, ", "))
                                            : fmt::format("its bits there are {}", fmt::join(bits, ", "));
    return show(Error{Fault::Usage,
                      fmt::format("{} lists no code '{}'; {}; `gantry explain {}` says what they stand for",
                                  profile->manual, wanted, meant != known.end() ? did_you_mean(*meant) : others, drive),
                      ""},
                json);
  }
  if (json) {
    show_document("ok", to_json(*profile, *found));
  } else {
    print_text("{}:{} ({}, {})\n  what:     {}{}\n  remedy:   {}\n  manual:   {}\n  becomes:  {}\n", profile->name,
               found->code, profile->title, found->where, found->text,
               found->kind.empty() || found->kind == "fault" ? "" : fmt::format(" ({})", found->kind), found->remedy,
               section_text(*profile, *found), becomes_text(*found));
  }
  return static_cast<int>(ExitCode::Done);
}

}  // namespace gantry::cli
