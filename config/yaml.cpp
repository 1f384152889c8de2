#include "config/yaml.hpp"

#include <algorithm>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <map>
#include <set>
#include <sstream>
#include <sys/stat.h>
#include <unistd.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include "config/yaml_slip.hpp"
#include "core/absolute_path.hpp"
#include "core/missing_file.hpp"

namespace gantry::config {
namespace {

/// Length of the UTF-8 sequence that starts at `text[at]`, 0 when it is none (overlong forms, surrogates and code
/// points above 10FFFFh included; Unicode 15, table 3-7).
std::size_t utf8_length(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) {
    return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : static_cast<unsigned char>(0);
  };
  const auto in = [](unsigned char b, int low, int high) { return b >= low && b <= high; };
  const unsigned char b0 = byte(0);
  if (b0 < 0x80) return 1;
  if (in(b0, 0xC2, 0xDF)) return in(byte(1), 0x80, 0xBF) ? 2 : 0;
  if (in(b0, 0xE0, 0xEF)) {
    const int low = b0 == 0xE0 ? 0xA0 : 0x80, high = b0 == 0xED ? 0x9F : 0xBF;
    return in(byte(1), low, high) && in(byte(2), 0x80, 0xBF) ? 3 : 0;
  }
  if (in(b0, 0xF0, 0xF4)) {
    const int low = b0 == 0xF0 ? 0x90 : 0x80, high = b0 == 0xF4 ? 0x8F : 0xBF;
    return in(byte(1), low, high) && in(byte(2), 0x80, 0xBF) && in(byte(3), 0x80, 0xBF) ? 4 : 0;
  }
  return 0;
}

/// What the text is once line ends are plain, and whether it may go on to the parser.
struct Clean {
  std::string text;
  bool readable = true;
};

/// Looks at every byte once: encoding, control characters, tabs, line ends. A tab that does not indent is reported and
/// read as a blank, so that the rest of the file is judged too.
Clean clean(std::string_view text, Mistakes& mistakes) {
  Clean out;
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
  out.text.reserve(text.size());
  Location location{1, 1};
  bool indent = true;
  const bool ends_in_cr = text.find('\n') == std::string_view::npos && std::ranges::count(text, '\r') > 1;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text, at);
    if (length == 0) {
      mistakes.add(Fault::YamlSyntax, "the file is not UTF-8 here; save it as UTF-8", location);
      out.readable = false;
      return out;
    }
    const auto c = static_cast<unsigned char>(text[at]);
    if (c == '\r' && at + 1 < text.size() && text[at + 1] == '\n') {
      ++at;
      continue;
    }
    if (c == '\r' && ends_in_cr) {
      mistakes.add(Fault::YamlSyntax,
                   "the lines of this file end with a carriage return alone (0x0D); save it with the line ends of Unix "
                   "or Windows",
                   location);
      out.readable = false;
      return out;
    }
    if (c == '\t') {
      mistakes.add(Fault::YamlSyntax, "a tab; indent and separate with blanks", location);
      out.readable = out.readable && !indent;
      out.text += ' ';
    } else if ((c < 0x20 && c != '\n') || c == 0x7F) {
      // One is told: a file that is no text has thousands.
      mistakes.add(Fault::YamlSyntax,
                   c == 0 ? "a NUL (0x00): this is no text, or UTF-16; save it as UTF-8"
                          : fmt::format("a control character (0x{:02X}); remove it", c),
                   location);
      out.readable = false;
      return out;
    } else {
      out.text.append(text, at, length);
    }
    indent = c == '\n' || (indent && (c == ' ' || c == '\t'));
    location = c == '\n' ? Location{location.line + 1, 1} : Location{location.line, location.column + 1};
    at += length;
  }
  return out;
}

/// Thrown by the handler to leave yaml-cpp's parser; caught in read_yaml.
struct Refusal {
  std::string message;
  Location location;
  Fault fault = Fault::FileTooLarge;
};

/// Turns the parser's events into nodes. yaml-cpp's own Node is not used: it lets duplicate keys pass and expands
/// aliases, which makes 400 bytes into two million nodes.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(std::string_view text, Mistakes& mistakes, const YamlBudget& budget)
      : text_(text), mistakes_(mistakes), budget_(budget) {}

  /// yaml-cpp counts columns in bytes; people count characters. Marks come in the order of the text, so that a long
  /// line is counted once and not once a value.
  Location location_of(const YAML::Mark& mark) {
    const auto pos = std::min(static_cast<std::size_t>(std::max(mark.pos, 0)), text_.size());
    const auto column = std::min(static_cast<std::size_t>(std::max(mark.column, 0)), pos);
    if (pos < counted_ || pos - column > counted_) counted_ = pos - column, characters_ = 0;
    for (; counted_ < pos; ++counted_) characters_ += (text_[counted_] & 0xC0) != 0x80;
    return {mark.line + 1, characters_ + 1};
  }

  /// Where the sign stands that begins an item in which nothing is; `otherwise` when there is none.
  [[nodiscard]] Location before(Location otherwise, std::size_t pos) const {
    const auto sign = pos == 0 ? std::string_view::npos : text_.find_last_of("-[,", pos - 1);
    if (sign == std::string_view::npos) return otherwise;
    const auto line_start = text_.rfind('\n', sign) + 1;  // npos + 1 is 0
    const auto characters = [&](std::size_t from, std::size_t to) {
      return static_cast<int>(std::count_if(text_.begin() + static_cast<std::ptrdiff_t>(from),
                                            text_.begin() + static_cast<std::ptrdiff_t>(to),
                                            [](char c) { return (c & 0xC0) != 0x80; }));
    };
    return {1 + static_cast<int>(std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(sign), '\n')),
            1 + characters(line_start, sign)};
  }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override {
    start(mark, Node::Kind::Empty);
    // The mark of nothing is that of what comes next; people look at the key that has no value.
    const std::string_view rest = text_.substr(std::min(static_cast<std::size_t>(std::max(mark.pos, 0)), text_.size()));
    const std::string_view word = rest.substr(0, rest.find_first_of(" \n,]}:#"));
    const bool written = word == "~" || word == "null" || word == "Null" || word == "NULL";
    if (!written && !levels_.empty() && levels_.back().node.kind == Node::Kind::Map && !levels_.back().awaits_key)
      value_.location = levels_.back().key.location;
    if (!written && !levels_.empty() && levels_.back().node.kind == Node::Kind::Sequence)
      value_.location = before(value_.location, text_.size() - rest.size());
    end_of_value();
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    mistakes_.add(Fault::YamlSyntax, "an alias (*name); write the value out here", location_of(mark));
    start(mark, Node::Kind::Refused);
    end_of_value();
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, const std::string& value) override {
    start(mark, Node::Kind::Scalar);
    value_.text = value;
    value_.quoted = tag == "!";
    if (refuse_tag(value_.location, tag)) value_.kind = Node::Kind::Refused;
    if (value_.quoted && !quote_ends(static_cast<std::size_t>(std::max(mark.pos, 0))))
      throw Refusal{"a quote that never ends", value_.location, Fault::YamlSyntax};
    end_of_value();
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    open(mark, tag, Node::Kind::Sequence);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, YAML::EmitterStyle::value) override {
    open(mark, tag, Node::Kind::Map);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapEnd() override { close(); }

  Node root;

 private:
  /// A container that is being filled. In a map the first value of a pair is its key.
  struct Level {
    Node node;
    bool refused = false;
    bool awaits_key = true;
    Node::Key key;
    bool key_refused = false;
    std::set<std::string, std::less<>> seen;
  };

  void count(const YAML::Mark& mark) {
    if (++nodes_ > budget_.nodes)
      throw Refusal{fmt::format("more than {} values; split the file", budget_.nodes), location_of(mark)};
  }
  void start(const YAML::Mark& mark, Node::Kind kind) {
    count(mark);
    value_ = Node{};
    value_.kind = kind;
    value_.location = location_of(mark);
  }
  /// yaml-cpp takes a quote that is open at the end of the file for closed.
  [[nodiscard]] bool quote_ends(std::size_t at) const {
    if (at >= text_.size() || (text_[at] != '"' && text_[at] != '\'')) return true;  // a block scalar
    const char quote = text_[at];
    for (std::size_t i = at + 1; i < text_.size(); ++i) {
      if (quote == '"' && text_[i] == '\\')
        ++i;
      else if (text_[i] == quote && quote == '\'' && i + 1 < text_.size() && text_[i + 1] == quote)
        ++i;
      else if (text_[i] == quote)
        return true;
    }
    return false;
  }
  bool refuse_tag(Location location, const std::string& tag) {
    if (tag.empty() || tag == "?" || tag == "!") return false;
    mistakes_.add(Fault::YamlSyntax, fmt::format("a tag ({}); leave it out", tag), location);
    return true;
  }
  void open(const YAML::Mark& mark, const std::string& tag, Node::Kind kind) {
    count(mark);
    if (levels_.size() >= budget_.depth)
      throw Refusal{fmt::format("nested deeper than {} levels", budget_.depth), location_of(mark)};
    Level level;
    level.node.kind = kind;
    level.node.location = location_of(mark);
    level.refused = refuse_tag(level.node.location, tag);
    levels_.push_back(std::move(level));
  }
  void close() {
    value_ = std::move(levels_.back().node);
    if (levels_.back().refused) value_.kind = Node::Kind::Refused;
    levels_.pop_back();
    end_of_value();
  }

  /// `value_` is whole: it is a key, a value of a map, an item of a sequence, or the document.
  void end_of_value() {
    if (levels_.empty()) {
      root = std::move(value_);
      return;
    }
    Level& level = levels_.back();
    if (level.node.kind == Node::Kind::Sequence) {
      level.node.items.push_back(std::move(value_));
    } else if (level.awaits_key) {
      take_key(level);
    } else {
      if (!level.key_refused) {
        level.node.keys.push_back(std::move(level.key));
        level.node.items.push_back(std::move(value_));
      }
      level.awaits_key = true;
    }
  }
  void take_key(Level& level) {
    level.awaits_key = false;
    level.key_refused = true;
    level.key = {value_.text, value_.location};
    if (value_.kind == Node::Kind::Refused) return;
    if (value_.kind != Node::Kind::Scalar) {
      mistakes_.add(Fault::YamlSyntax, "a key that is no plain word", value_.location);
    } else if (!level.seen.insert(value_.text).second) {
      mistakes_.add(Fault::DuplicateKey,
                    fmt::format("'{}' stands twice here; remove one, or write the line that begins another one above",
                                value_.text),
                    value_.location);
      level.key_refused = !forget_empty(level.node, value_.text);
    } else {
      level.key_refused = false;
    }
  }

  /// Of a key that stands twice the one behind which nothing stands is not meant.
  static bool forget_empty(Node& map, std::string_view key) {
    for (std::size_t i = 0; i < map.keys.size(); ++i)
      if (map.keys[i].text == key && map.items[i].kind == Node::Kind::Empty) {
        map.keys.erase(map.keys.begin() + static_cast<std::ptrdiff_t>(i));
        map.items.erase(map.items.begin() + static_cast<std::ptrdiff_t>(i));
        return true;
      }
    return false;
  }

  std::string_view text_;
  Mistakes& mistakes_;
  const YamlBudget& budget_;
  std::size_t counted_ = 0;  ///< bytes up to which characters_ of their line are counted
  int characters_ = 0;
  std::size_t nodes_ = 0;
  std::vector<Level> levels_;
  Node value_;
};

}  // namespace

void Mistakes::add(Fault fault, std::string_view message, Location location) {
  if (full()) {
    ++more_;
    return;
  }
  rows_.push_back({fault, shortened(message, kLongest), location});
}

std::vector<Error> Mistakes::errors() const {
  std::vector<Row> rows = rows_;
  std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.location < b.location; });
  constexpr std::size_t kPlaces = 5;  // that are listed
  std::vector<Error> out;
  std::map<std::string_view, std::size_t> unknown;  // by its message, where it is in `out`
  std::vector<std::vector<Location>> again;
  for (const Row& row : rows) {
    if (row.fault == Fault::UnknownReference || row.fault == Fault::UnknownKey) {
      const auto [seen, is_new] = unknown.try_emplace(row.message, out.size());
      if (!is_new) {
        again[seen->second].push_back(row.location);
        continue;
      }
    }
    again.emplace_back();
    out.push_back(
        {row.fault, row.message,
         row.location.line > 0 ? fmt::format("{}:{}:{}", file_, row.location.line, row.location.column) : file_});
  }
  for (std::size_t n = 0; n < out.size(); ++n) {
    for (std::size_t k = 0; k < std::min(again[n].size(), kPlaces); ++k)
      out[n].message += fmt::format("{}{}:{}", k == 0 ? "; the same at " : ", ", again[n][k].line, again[n][k].column);
    if (again[n].size() > kPlaces) out[n].message += fmt::format(" and {} more places", again[n].size() - kPlaces);
  }
  if (more_ > 0) out.push_back({Fault::BadValue, fmt::format("and {} more mistakes", more_), file_});
  return out;
}

const Node* Node::find(std::string_view key) const {
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (keys[i].text == key) return &items[i];
  return nullptr;
}

namespace {

bool has_line(std::string_view text, std::string_view begin) {
  return text.starts_with(begin) || text.find("\n" + std::string(begin)) != std::string_view::npos;
}

/// The '---' above what it holds.
Location begin_of_document(std::string_view text, Location content) {
  Location found = content;
  int line = 1;
  for (std::size_t at = 0; at < text.size() && line <= content.line; ++line) {
    if (line > 1 && text.substr(at).starts_with("---")) found.line = line, found.column = 1;
    const std::size_t end = text.find('\n', at);
    if (end == std::string_view::npos) break;
    at = end + 1;
  }
  return found;
}

}  // namespace

std::optional<Node> read_yaml(std::string_view text, Mistakes& mistakes, const YamlBudget& budget) {
  if (text.size() > budget.bytes) {
    mistakes.add(Fault::FileTooLarge, fmt::format("larger than {} bytes; split the file", budget.bytes), {1, 1});
    return std::nullopt;
  }
  const Clean plain = clean(text, mistakes);
  if (!plain.readable) return std::nullopt;
  TreeBuilder tree(plain.text, mistakes, budget);
  try {
    std::istringstream in(plain.text);
    YAML::Parser parser(in);
    if (!parser.HandleNextDocument(tree)) {
      mistakes.add(Fault::YamlSyntax, "the file is empty", {1, 1});
      return std::nullopt;
    }
    TreeBuilder second(plain.text, mistakes, budget);
    if (parser.HandleNextDocument(second)) {
      const bool has_mark = has_line(plain.text, "---") || has_line(plain.text, "...");
      mistakes.add(Fault::YamlSyntax,
                   has_mark
                       ? "a second document (behind --- or ...); one file holds one: leave that line out"
                       : "this line stands further left than what is above, and begins another document; begin the "
                         "keys of the file in one column",
                   begin_of_document(plain.text, second.root.location));
      return std::nullopt;
    }
  } catch (const Refusal& refusal) {
    mistakes.add(refusal.fault, refusal.message, refusal.location);
    return std::nullopt;
  } catch (const YAML::Exception& error) {
    const auto at = static_cast<std::size_t>(std::max(error.mark.is_null() ? 0 : error.mark.pos, 0));
    const YamlSlip slip = yaml_slip(plain.text, at, error.msg);
    const auto location = line_and_column(plain.text, slip.at);
    mistakes.add(Fault::YamlSyntax, slip.message, {location.line, location.column});
    return std::nullopt;
  } catch (const std::exception& error) {
    mistakes.add(Fault::YamlSyntax, fmt::format("not well-formed YAML: {}", error.what()), {1, 1});
    return std::nullopt;
  }
  return std::move(tree.root);
}

Result<std::string> read_text_file(const std::string& path, std::size_t max_bytes) {
  // O_NONBLOCK: a pipe that nobody writes must not hold the program up.
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) {
    const int why = errno;
    if (const auto seen = absolute_path(path); !seen) return fail(Fault::FileUnreadable, seen.error().message, path);
    if (why == ENOENT || why == ENOTDIR) return fail(Fault::FileUnreadable, missing_in_words(path), path);
    return fail(Fault::FileUnreadable, fmt::format("cannot be opened ({}); check the path", strerror(why)), path);
  }
  struct stat info {};
  std::string text;
  bool ok = ::fstat(fd, &info) == 0 && S_ISREG(info.st_mode);
  const bool too_large = ok && static_cast<std::size_t>(info.st_size) > max_bytes;
  if (ok && !too_large) {
    text.resize(static_cast<std::size_t>(info.st_size));
    std::size_t have = 0;
    while (ok && have < text.size()) {
      const ssize_t got = ::read(fd, text.data() + have, text.size() - have);
      if (got <= 0)
        ok = false;
      else
        have += static_cast<std::size_t>(got);
    }
  }
  ::close(fd);
  if (too_large) return fail(Fault::FileTooLarge, fmt::format("larger than {} bytes; split the file", max_bytes), path);
  if (!ok && S_ISDIR(info.st_mode)) return fail(Fault::FileUnreadable, "is a folder; name a file", path);
  if (!ok) return fail(Fault::FileUnreadable, "is no regular file that can be read", path);
  return text;
}

std::vector<std::string> yaml_files_in(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::string shortened(std::string_view text, std::size_t bytes) {
  if (text.size() <= bytes) return std::string(text);
  while (bytes > 0 && (text[bytes] & 0xC0) == 0x80) --bytes;
  return std::string(text.substr(0, bytes)) + "...";
}

}  // namespace gantry::config
