#include "app/cli/plan_questions.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <optional>
#include <set>

#include "config/yaml.hpp"
#include "core/near_word.hpp"
#include "core/units.hpp"
#include "motion/plan/certificate.hpp"
#include "motion/plan/search_path.hpp"

namespace gantry::cli {
namespace {

using Json = nlohmann::ordered_json;
constexpr std::size_t kMostBytes = 64u << 20;
constexpr double kFarthest_mm = 1e12;  // beyond it squares of lengths are no lengths any more
constexpr double kFarthest_deg = 1e6;  // a turn is looked at in parts

/// "line:col" of a byte.
std::string place_in(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(text.size(), byte > 0 ? byte - 1 : 0));
  const auto line_start = before.rfind('\n');
  return fmt::format("{}:{}", 1 + std::count(before.begin(), before.end(), '\n'),
                     before.size() - (line_start == std::string_view::npos ? 0 : line_start + 1) + 1);
}

/// The bytes of a text, counted as the parser takes them: the one way to learn where it is.
class Counted {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;
  Counted(const char* at, std::size_t* taken) : at_(at), taken_(taken) {}
  reference operator*() const { return *at_; }
  Counted& operator++() {
    ++at_, ++*taken_;
    return *this;
  }
  friend bool operator!=(const Counted& a, const Counted& b) { return a.at_ != b.at_; }
  friend bool operator==(const Counted& a, const Counted& b) { return a.at_ == b.at_; }

 private:
  const char* at_;
  std::size_t* taken_;
};

/// Where the rows of a list stand and their keys: bytes, counted from 1.
struct RowLocations {
  std::size_t row = 1;
  std::vector<std::pair<std::string, std::size_t>> keys;
  [[nodiscard]] std::size_t of(const std::string& key) const {
    for (const auto& [name, byte] : keys)
      if (name == key) return byte;
    return row;
  }
};

using Ends = std::array<std::string_view, 2>;  ///< keys of a question's two positions
constexpr Ends kQueryEnds{"start", "goal"}, kMotionEnds{"from", "to"};

class Reader {
 public:
  Reader(std::string path, Ends ends, Turns turns) : path_(std::move(path)), ends_(ends), turns_(turns) {}

  Checked<std::vector<Question>> read() {
    const auto text = config::read_text_file(path_, kMostBytes);
    if (!text) return tl::unexpected(std::vector{text.error()});
    text_ = *text;
    Json root;
    std::size_t taken = 0;
    const auto see = [&](int depth, Json::parse_event_t event, const Json& value) {
      if (depth == 1 && (event == Json::parse_event_t::object_start || event == Json::parse_event_t::array_start ||
                         event == Json::parse_event_t::value))
        locations_.push_back({taken, {}});
      if (depth == 2 && event == Json::parse_event_t::key && !locations_.empty()) {
        auto key = value.get<std::string>();
        const std::size_t quotes_and_all = std::min(taken - 1, key.size() + 1);
        locations_.back().keys.emplace_back(std::move(key), taken - quotes_and_all);
      }
      return true;
    };
    try {
      root = Json::parse(Counted(text_.data(), &taken), Counted(text_.data() + text_.size(), &taken), see);
    } catch (const nlohmann::json::parse_error& error) {
      add(Fault::BadValue, error.byte, fmt::format("this is no JSON ({})", error.what()));
      return tl::unexpected(std::move(errors_));
    } catch (const nlohmann::json::exception& error) {  // a number that no double holds
      add(Fault::BadValue, taken, error.what());
      return tl::unexpected(std::move(errors_));
    }
    if (!root.is_array()) {
      add(Fault::BadValue, 1,
          fmt::format("a list is expected: [{{\"id\": 1, \"{}\": [x, y, z], \"{}\": [x, y, z]}}]", ends_[0], ends_[1]));
      return tl::unexpected(std::move(errors_));
    }
    if (is_of_the_other_kind(root)) {
      const bool queries = ends_[0] == kMotionEnds[0];
      add(Fault::BadValue, locations_.front().row,
          queries
              ? "these are queries ('start' and 'goal'), not motions ('from' and 'to'); give the file as --queries"
              : "these are motions ('from' and 'to'), not queries ('start' and 'goal'); give the file as --motions");
      return tl::unexpected(std::move(errors_));
    }
    for (std::size_t i = 0; i < root.size() && errors_.size() < config::Mistakes::kMost; ++i)
      take(root[i], locations_.at(i));
    if (!errors_.empty()) return tl::unexpected(std::move(errors_));
    return std::move(questions_);
  }

 private:
  void add(Fault fault, std::size_t byte, std::string message) {
    errors_.push_back({fault, std::move(message), fmt::format("{}:{}", path_, place_in(text_, byte))});
  }

  /// Every row has the keys of the other kind of question, and none of its own.
  [[nodiscard]] bool is_of_the_other_kind(const Json& rows) const {
    const Ends& others = ends_[0] == kMotionEnds[0] ? kQueryEnds : kMotionEnds;
    return !rows.empty() && std::all_of(rows.begin(), rows.end(), [&](const Json& row) {
      return row.is_object() && row.contains(others[0]) && row.contains(others[1]) && !row.contains(ends_[0]) &&
             !row.contains(ends_[1]);
    });
  }

  void take(const Json& row, const RowLocations& at) {
    if (!row.is_object())
      return add(Fault::BadValue, at.row, fmt::format("expected {{\"id\", \"{}\", \"{}\"}}", ends_[0], ends_[1]));
    const std::vector<std::string> known{"id", std::string(ends_[0]), std::string(ends_[1])};
    for (const auto& [key, value] : row.items())
      if (std::find(known.begin(), known.end(), key) == known.end())
        add(Fault::UnknownKey, at.of(key),
            fmt::format("unknown key '{}'; {}", config::shortened(key, 40),
                        did_you_mean(key, {known.begin(), known.end()})));
    std::set<std::string_view> seen;
    for (const auto& [key, byte] : at.keys)
      if (!seen.insert(key).second)
        add(Fault::DuplicateKey, byte,
            fmt::format("the key '{}' stands twice; remove one", config::shortened(key, 40)));
    Question out;
    const auto id = row.find("id");
    if (id == row.end())
      return add(Fault::MissingKey, at.row, "the key 'id' is missing; give a text or a whole number");
    if (!id->is_string() && !id->is_number_integer())
      return add(Fault::BadValue, at.of("id"), "expected a text or a whole number");
    out.id = *id;
    if (!ids_.insert(id->dump(-1, ' ', true, Json::error_handler_t::replace)).second)
      add(Fault::DuplicateKey, at.of("id"), "this id stands twice; give each its own");
    const auto from = point(row, ends_[0], at), to = point(row, ends_[1], at);
    if (!from || !to) return;
    out.from = *from, out.to = *to;
    questions_.push_back(std::move(out));
  }

  std::optional<Position> point(const Json& row, std::string_view key_of, const RowLocations& at) {
    const std::string key(key_of);
    const auto found = row.find(key);
    if (found == row.end()) {
      add(Fault::MissingKey, at.row, fmt::format("the key '{}' is missing; give [x, y, z] in mm", key));
      return std::nullopt;
    }
    const bool numbers = found->is_array() && std::all_of(found->begin(), found->end(), [](auto& v) {
                           return v.is_number() && std::isfinite(v.template get<double>());
                         });
    if (numbers && found->size() == 4 && turns_ == Turns::No) {
      add(Fault::BadValue, at.of(key),
          "expected three numbers, [x, y, z] in mm: no body of this head turns (`on_turn: true`), so that there is no "
          "C");
      return std::nullopt;
    }
    if (!numbers || (found->size() != 3 && found->size() != 4)) {
      add(Fault::BadValue, at.of(key),
          turns_ == Turns::Yes ? "expected three numbers, [x, y, z] in mm, or four, [x, y, z, c] with c in degrees"
                               : "expected three numbers, [x, y, z] in mm");
      return std::nullopt;
    }
    const auto number = [&](std::size_t i) { return (*found)[i].get<double>(); };
    if (std::max({std::abs(number(0)), std::abs(number(1)), std::abs(number(2))}) > kFarthest_mm) {
      add(Fault::BadValue, at.of(key), fmt::format("farther than {:g} mm from the origin; give mm", kFarthest_mm));
      return std::nullopt;
    }
    if (found->size() == 4 && std::abs(number(3)) > kFarthest_deg) {
      add(Fault::BadValue, at.of(key),
          fmt::format("C is {:.9g} degrees; give one within -{:g} and {:g}", number(3), kFarthest_deg, kFarthest_deg));
      return std::nullopt;
    }
    return Position{{number(0), number(1), number(2)}, found->size() == 4 ? number(3) : 0};
  }

  std::string path_, text_;
  Ends ends_;
  Turns turns_;
  std::vector<RowLocations> locations_;
  std::vector<Error> errors_;
  std::vector<Question> questions_;
  std::set<std::string> ids_;
};

constexpr std::size_t kC = 3;  // of the axes, where it is there

AxisVec axes(const Position& p) { return {p.tip.x, p.tip.y, p.tip.z, units::rad(p.c_deg)}; }
Json json(Vec3 p) { return Json::array({p.x, p.y, p.z}); }
/// Of a path; an end as it was asked for, to the last digit.
Json json(const motion::Scene& scene, const AxisVec& q, const Question& asked) {
  Json row = Json::array({q[0], q[1], q[2]});
  if (scene.axes().size() <= kC) return row;
  for (const Position* end : {&asked.from, &asked.to})
    if (q == axes(*end)) return row.push_back(end->c_deg), row;
  row.push_back(units::deg(q[kC]));
  return row;
}
Json names(const motion::Scene& scene, std::size_t head, std::size_t standing) {
  return Json::array({scene.head()[head].name, scene.standing()[standing].name});
}
const Json kWorkspace = Json::array({"tip", "workspace"});

double us_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

const char* word(motion::SearchStatus status) {
  using enum motion::SearchStatus;
  switch (status) {
    case Ok: return "ok";
    case StartCollides: return "start_collides";
    case GoalCollides: return "goal_collides";
    case NoPath: return "no_path";
    case Budget: break;
  }
  return "budget";
}

/// The share of the motion at which the tip leaves the workspace; nothing when it never does.
std::optional<double> leaves_at(const motion::Scene& scene, const AxisVec& from, const AxisVec& to) {
  if (motion::beyond_limits(scene, from)) return 0;
  if (!motion::beyond_limits(scene, to)) return std::nullopt;
  double first = 1;
  for (std::size_t i = 0; i < scene.axes().size(); ++i) {
    const auto& a = scene.axes()[i];
    const double step = to[i] - from[i];
    if (to[i] > a.p_max) first = std::min(first, (a.p_max - from[i]) / step);
    if (to[i] < a.p_min) first = std::min(first, (a.p_min - from[i]) / step);
  }
  return std::max(0.0, first);
}

}  // namespace

Checked<std::vector<Question>> read_queries(const std::string& path, Turns turns) {
  return Reader(path, kQueryEnds, turns).read();
}
Checked<std::vector<Question>> read_motions(const std::string& path, Turns turns) {
  return Reader(path, kMotionEnds, turns).read();
}

Json answer_queries(const motion::Scene& scene, double clearance_mm, const std::vector<Question>& queries) {
  auto rows = Json::array();
  for (const Question& query : queries) {
    Json row{{"id", query.id},        {"status", ""},         {"closed_in", nullptr},
             {"path", Json::array()}, {"length_mm", nullptr}, {"min_clearance_mm", nullptr},
             {"pair", nullptr},       {"point", nullptr},     {"plan_us", nullptr}};
    const auto start = std::chrono::steady_clock::now();
    auto found = motion::search_path(scene, axes(query.from), axes(query.to), {clearance_mm, {}});
    Result<motion::Certificate> proof;
    if (found.status == motion::SearchStatus::Ok) proof = motion::certify(scene, found.points, {clearance_mm, {}});
    if (!proof) found.status = motion::SearchStatus::Budget;  // what is not proved is not offered
    row["plan_us"] = us_since(start);
    row["status"] = word(found.status);
    if (found.closed_in != motion::ClosedIn::Neither)
      row["closed_in"] = found.closed_in == motion::ClosedIn::Start ? "start" : "goal";
    if (found.beyond) row["pair"] = kWorkspace;
    if (found.hit)
      row["pair"] = names(scene, found.hit->head, found.hit->standing), row["point"] = json(found.hit->point);
    if (found.status == motion::SearchStatus::Ok) {
      for (const AxisVec& q : found.points) row["path"].push_back(json(scene, q, query));
      row["length_mm"] = found.length_mm;
      if (const motion::NearPair& near = proof->nearest.others; std::isfinite(near.distance_mm)) {
        row["min_clearance_mm"] = near.distance_mm;
        row["pair"] = names(scene, near.head, near.standing), row["point"] = json(near.at);
      }
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

Json answer_motions(const motion::Scene& scene, double clearance_mm, const std::vector<Question>& motions) {
  auto rows = Json::array();
  const motion::Margins margins{clearance_mm, {}};
  for (const Question& each : motions) {
    const AxisVec from = axes(each.from), to = axes(each.to);
    Json row{{"id", each.id},    {"free", false},          {"pair", nullptr},    {"t", nullptr},
             {"point", nullptr}, {"distance_mm", nullptr}, {"check_us", nullptr}};
    const auto start = std::chrono::steady_clock::now();
    const bool clear = motion::is_clear(scene, from, to, margins);
    row["check_us"] = us_since(start);
    std::optional<motion::Certificate> proved;
    if (clear)
      if (auto certificate = motion::certify(scene, std::array{from, to}, {clearance_mm, {}}))
        proved = *std::move(certificate);
    const bool free = proved.has_value();  // what is not proved is not free
    const auto left = leaves_at(scene, from, to);
    row["free"] = free && !left;
    motion::NearPairs nearest;
    if (free)
      nearest = proved->nearest;
    else
      motion::measure_nearest(scene, from, to, margins, 0, nearest);
    const motion::NearPair& near = nearest.others;
    if (std::isfinite(near.distance_mm)) {
      row["distance_mm"] = near.distance_mm;
      row["pair"] = names(scene, near.head, near.standing), row["point"] = json(near.at);
    }
    if (const auto hit = free ? std::nullopt : motion::first_hit(scene, from, to, margins)) {
      row["t"] = hit->fraction;
      row["pair"] = names(scene, hit->head, hit->standing), row["point"] = json(hit->point);
    }
    if (left && (row["t"].is_null() || *left < row["t"].get<double>())) {
      row["t"] = *left, row["pair"] = kWorkspace;
      row["point"] = json(each.from.tip + (each.to.tip - each.from.tip) * *left);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace gantry::cli
