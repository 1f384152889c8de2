#include "recipes/points_file.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>

#include "core/trimmed.hpp"

namespace gantry::recipes {
namespace {

namespace fs = std::filesystem;
using config::At;
using config::Location;
using config::Mistakes;

/// A field of a line and its column, from 1.
struct Cell {
  std::string_view text;
  int column = 1;
};
std::vector<Cell> cells_of(std::string_view line) {
  std::vector<Cell> out;
  for (std::size_t from = 0;;) {
    const std::size_t comma = line.find(',', from);
    const std::string_view raw = line.substr(from, comma == std::string_view::npos ? comma : comma - from);
    const std::string_view text = trimmed(raw);
    out.push_back(
        {text, static_cast<int>((text.empty() ? from : static_cast<std::size_t>(text.data() - line.data())) + 1)});
    if (comma == std::string_view::npos || out.size() > 4) return out;
    from = comma + 1;
  }
}

std::string shown(std::string_view text) { return config::shortened(text, 40); }

class Reader {
 public:
  explicit Reader(Mistakes& mistakes) : mistakes_(mistakes) {}

  std::vector<At<Vec3>> read(std::string_view csv) {
    if (csv.starts_with("\xEF\xBB\xBF")) csv.remove_prefix(3);
    for (int number = 1; !csv.empty() && !mistakes_.full(); ++number) {
      const std::size_t end = csv.find('\n');
      std::string_view line = csv.substr(0, end);
      csv.remove_prefix(end == std::string_view::npos ? csv.size() : end + 1);
      if (line.ends_with('\r')) line.remove_suffix(1);
      if (trimmed(line).empty()) continue;
      if (!(columns_ == 0 ? header(line, number) : row(line, number))) break;
    }
    if (columns_ == 0 && mistakes_.none())
      mistakes_.add(Fault::MissingKey, "the file is empty; write x_mm,y_mm and then a point a line", {1, 1});
    return std::move(points_);
  }

 private:
  bool header(std::string_view line, int number) {
    constexpr std::array kNames{std::array{"x_mm", "y_mm", "z_mm"}, std::array{"x", "y", "z"}};
    const auto cells = cells_of(line);
    for (const auto& names : kNames) {
      bool same = cells.size() == 2 || cells.size() == 3;
      for (std::size_t i = 0; same && i < cells.size(); ++i) same = cells[i].text == names[i];
      if (same) columns_ = cells.size();
    }
    if (columns_ != 0) return true;
    mistakes_.add(
        Fault::BadValue,
        fmt::format("'{}' stands here; the first line names the columns: x_mm,y_mm or x_mm,y_mm,z_mm", shown(line)),
        {number, 1});
    return false;
  }

  /// False: no use in reading on.
  bool row(std::string_view line, int number) {
    if (points_.size() >= kMostPoints) {
      mistakes_.add(Fault::TooManySteps, fmt::format("more than {} points; split the file", kMostPoints), {number, 1});
      return false;
    }
    const auto cells = cells_of(line);
    if (const auto semicolon = line.find(';'); semicolon != std::string_view::npos) {
      mistakes_.add(Fault::BadValue, "';' stands here; write commas between the columns and points in the numbers",
                    {number, static_cast<int>(semicolon) + 1});
      return false;  // so it goes on to the last line
    }
    if (cells.size() != columns_) {
      mistakes_.add(Fault::BadValue,
                    fmt::format("{}{} values stand here; the header names {}{}", cells.size() > 4 ? "more than " : "",
                                std::min<std::size_t>(cells.size(), 4), columns_,
                                cells.size() > columns_ ? "; write a point in a number, not a comma" : ""),
                    {number, 1});
      return true;
    }
    std::array<double, 3> xyz{};
    for (std::size_t i = 0; i < columns_; ++i)
      if (!value(cells[i], number, i == 2, xyz[i])) return true;
    points_.push_back({{xyz[0], xyz[1], xyz[2]}, {number, cells[0].column}});
    return true;
  }

  bool value(const Cell& cell, int number, bool height, double& to) {
    const auto [end, ec] = std::from_chars(cell.text.data(), cell.text.data() + cell.text.size(), to);
    const Location location{number, cell.column};
    if (ec != std::errc{} || end != cell.text.data() + cell.text.size() || !std::isfinite(to)) {
      mistakes_.add(Fault::BadValue,
                    cell.text.empty()
                        ? std::string("a number is missing here; write millimetres, such as 12.5")
                        : fmt::format("'{}' is no number; write millimetres, such as 12.5", shown(cell.text)),
                    location);
      return false;
    }
    const config::Range range = height ? kHeight : kOnBoard;
    if (to >= range.min && to <= range.max) return true;
    mistakes_.add(Fault::OutOfRange, fmt::format("{} mm is outside {} mm .. {} mm", to, range.min, range.max),
                  location);
    return false;
  }

  Mistakes& mistakes_;
  std::size_t columns_ = 0;
  std::vector<At<Vec3>> points_;
};

Result<std::string> path_beside(const std::string& recipe_file, const std::string& name) {
  const fs::path relative(name);
  bool leaves = relative.is_absolute() || relative.empty() || name.find('\0') != std::string::npos;
  for (const fs::path& part : relative) leaves = leaves || part == "..";
  if (leaves)
    return fail(Fault::BadValue,
                fmt::format("'{}' leads out of the recipe's folder; put the file beside the recipe and write its name",
                            shown(name)));
  fs::path folder = fs::path(recipe_file).parent_path();
  if (folder.empty()) folder = ".";
  std::error_code error;
  const fs::path real_folder = fs::canonical(folder, error);
  const fs::path file = error ? fs::path() : fs::canonical(folder / relative, error);
  if (error)
    return fail(Fault::FileUnreadable,
                fmt::format("'{}' cannot be read ({}); it is looked for in the folder of the recipe, {}", shown(name),
                            error.message(), folder.generic_string()));
  const auto differ = std::mismatch(real_folder.begin(), real_folder.end(), file.begin(), file.end());
  if (differ.first != real_folder.end())
    return fail(
        Fault::BadValue,
        fmt::format("'{}' is a link that leads out of the recipe's folder; put the file itself there", shown(name)));
  return file.string();
}

}  // namespace

std::vector<At<Vec3>> read_points(std::string_view csv, Mistakes& mistakes) { return Reader(mistakes).read(csv); }

std::string shown_beside(std::string_view recipe_file, const std::string& name) {
  return (fs::path(recipe_file).parent_path() / name).generic_string();
}

Result<std::string> read_beside(const std::string& recipe_file, const std::string& name) {
  const auto path = path_beside(recipe_file, name);
  if (!path) return path;
  auto text = config::read_text_file(*path, kMostBytesOfPoints);
  if (!text) text.error().message = fmt::format("'{}': {}", shown(name), text.error().message);
  return text;
}

}  // namespace gantry::recipes
