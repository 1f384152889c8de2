// THE one place that reads YAML. Text becomes a tree of nodes that know where they stand; what YAML readers disagree
// about, or what only multiplies, is refused with its location. It never throws and never expands anything.
//   Mistakes mistakes("recipes/board.yaml");
//   std::optional<Node> root = read_yaml(text, mistakes);   // nullopt: not well-formed, mistakes says where
// Tables of fields (config/fields.hpp) turn the tree into structs.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"

namespace gantry::config {

/// Line and column from 1, in characters; 0: nowhere in the file.
struct Location {
  int line = 0, column = 0;
  constexpr auto operator<=>(const Location&) const = default;
};

/// All mistakes of one file. Keeps the first kMost of them and counts the rest; a message is cut after kLongest bytes.
class Mistakes {
 public:
  static constexpr std::size_t kMost = 100, kLongest = 1000;
  struct Row {
    Fault fault;
    std::string message;
    Location location;
    bool operator==(const Row&) const = default;
  };
  explicit Mistakes(std::string file) : file_(std::move(file)) {}
  void add(Fault fault, std::string_view message, Location location);
  [[nodiscard]] bool none() const { return rows_.empty(); }
  /// What is added from here on is only counted.
  [[nodiscard]] bool full() const { return rows_.size() >= kMost; }
  [[nodiscard]] const std::string& file() const { return file_; }
  /// Those that are kept, as they were added.
  [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }
  /// In the order of the file, `where` set to "file:line:col". One name that is not there, one key that is
  /// unknown, is one error, with its places.
  [[nodiscard]] std::vector<Error> errors() const;

 private:
  std::string file_;
  std::vector<Row> rows_;
  std::size_t more_ = 0;
};

struct Node {
  enum class Kind : std::uint8_t {
    Empty,  ///< "key:" with nothing after it, ~ or null
    Scalar,
    Sequence,
    Map,
    Refused,  ///< already a mistake (an alias): readers pass over it in silence
  };
  struct Key {
    std::string text;
    Location location;
  };
  Kind kind = Kind::Empty;
  bool quoted = false;
  Location location;
  std::string text;         ///< of a scalar
  std::vector<Node> items;  ///< of a sequence; the values of a map
  std::vector<Key> keys;    ///< of a map: keys[i] names items[i]; no key stands twice

  [[nodiscard]] const Node* find(std::string_view key) const;
};

/// Bounds that hold before anything is built. yaml-cpp takes 0.25 s and 100 MB for 1 MiB of brackets; within these
/// bounds no text takes much longer than a file full of points, about 0.2 s.
struct YamlBudget {
  std::size_t bytes = 512u << 10;
  std::size_t nodes = 120000;
  std::size_t depth = 32;
};

/// One document of UTF-8 text. Refused with their location: other encodings, control characters, tabs, a carriage
/// return without a line feed, a second document, aliases, tags, keys that are no text, duplicate keys, and what is
/// over budget. A byte-order mark at the start and CRLF are read.
std::optional<Node> read_yaml(std::string_view text, Mistakes& mistakes, const YamlBudget& budget = {});

/// A regular file's text. Fault::FileUnreadable, Fault::FileTooLarge.
Result<std::string> read_text_file(const std::string& path, std::size_t max_bytes = YamlBudget{}.bytes);

/// Text for a message, cut after so many bytes, never within a character.
std::string shortened(std::string_view text, std::size_t bytes);

/// Names, without their ending, of the .yaml files in a folder, sorted; none where it cannot be read.
std::vector<std::string> yaml_files_in(const std::string& folder);

}  // namespace gantry::config
