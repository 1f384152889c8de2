#include "app/record/report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <limits>
#include <regex>

#include "app/record/deposit_figures.hpp"
#include "app/record/envelope_line.hpp"
#include "app/record/html.hpp"
#include "app/record/polyline.hpp"
#include "app/record/report_plots.hpp"
#include "app/record/summary.hpp"
#include "tests/app/record/made_up_job.hpp"
#include "tests/app/record/page_scene.hpp"
#include "tests/app/record/snapshots.hpp"

namespace gantry::record {
namespace {

std::string content(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<std::byte> bytes(std::string_view s) {
  std::vector<std::byte> result;
  for (const char c : s) result.push_back(static_cast<std::byte>(c));
  return result;
}

TEST(Report, lists_a_deposit_that_is_off_its_gap_before_one_that_is_less_beside) {
  JobResult r = made_up_job();
  ASSERT_GT(r.deposits.size(), 6u);
  Deposit& high = r.deposits[5];
  high.asked_gap_mm = 0.2, high.gap_mm = 0.893, high.error_mm = 0;
  const std::string page = report_page(r);
  const std::size_t table = page.find("<h2>Deposits");
  ASSERT_NE(table, std::string::npos);
  const std::size_t first = page.find(html::text(high.id), table),
                    other = page.find(html::text(r.deposits[4].id), table);
  EXPECT_LT(first, other);
  EXPECT_NEAR(part_of_allowed(r, high), 0.693 / allowed(r, high).gap_mm, 1e-9);
}

TEST(Html, escapes_what_has_a_meaning_in_html) {
  EXPECT_EQ(html::text("<b a=\"1\">&'"), "&lt;b a=&quot;1&quot;&gt;&amp;&#39;");
  EXPECT_EQ(html::text("Würfel µ"), "Würfel µ");
  EXPECT_EQ(html::text("a\xff\xc3(b\x01"), "a\xEF\xBF\xBD\xEF\xBF\xBD(b\xEF\xBF\xBD");
  EXPECT_EQ(html::text("a\u202Eb\u009B"),
            "a\xEF\xBF\xBD"
            "b\xEF\xBF\xBD")
      << "bidi, C1";
  EXPECT_EQ(html::text("\xed\xa0\x80"), "\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD") << "a surrogate is no character";
}

TEST(Html, base64_agrees_with_the_vectors_of_rfc_4648) {
  const char* vectors[][2] = {{"", ""},
                              {"f", "Zg=="},
                              {"fo", "Zm8="},
                              {"foo", "Zm9v"},
                              {"foob", "Zm9vYg=="},
                              {"fooba", "Zm9vYmE="},
                              {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, coded] : vectors) EXPECT_EQ(html::base64(bytes(plain)), coded);
}

TEST(Html, numbers_are_never_nan_or_negative_zero) {
  EXPECT_EQ(html::number(std::numeric_limits<double>::quiet_NaN(), 2), "–");
  EXPECT_EQ(html::number(-0.0001, 2), "0.00");
  EXPECT_EQ(html::number(-0.01, 2), "-0.01");
  EXPECT_EQ(html::duration(12'300), "12.3 µs");
}

TEST(Report, tells_the_job_in_one_file_that_needs_no_other) {
  const Folder folder;
  auto r = made_up_job();
  r.marks[0].png = bytes("\x89PNG pretended");
  ASSERT_TRUE(write_report(folder.path, r));
  ASSERT_TRUE(write_image(folder.path, image_names(r)[0], r.marks[0]));
  const auto page = content(folder.path + "/report.html");
  for (const char* part : {"demo-board", "Done", "30 / 30", "lower left", "dots[3][5]", "Touched heights", "n/a",
                           "0x3f9ac27780be1d05", "C7 capacitor", "148 motions proved free", "data:image/png;base64,"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  const auto markup = markup_of(page);  // what the scripts reach is scene_test's
  for (const char* outside : {"http://", "https://", "<link", "url(\"", "nan", "inf\""})
    EXPECT_EQ(markup.find(outside), std::string::npos) << outside;
  EXPECT_EQ(content(folder.path + "/marks/lower-left.png"), "\x89PNG pretended");
}

/// Where a digit takes 6.1 px at 11 px (wide sans serifs), and a blank and an s less.
void expect_words_within(const std::string& svg) {
  const double width = std::stod(svg.substr(svg.find("viewBox=\"0 0 ") + 13));
  const std::regex words("<text x=\"([^\"]*)\"[^>]* class=\"tick[^>]*text-anchor=\"([a-z]*)\">([^<]*)<");
  int seen = 0;
  for (auto at = std::sregex_iterator(svg.begin(), svg.end(), words); at != std::sregex_iterator(); ++at, ++seen) {
    const double x = std::stod((*at)[1]), long_px = 6.1 * static_cast<double>((*at)[3].length());
    EXPECT_LE(x + ((*at)[2] == "end" ? 0 : (*at)[2] == "middle" ? long_px / 2 : long_px), width) << at->str();
  }
  EXPECT_GT(seen, 4);
}

TEST(Report, words_below_a_plot_are_not_cut_at_its_edge) {
  for (const double lasts_s : {30., 60., 120., 240., 1800.}) {
    auto r = made_up_job();
    for (auto* path : {&r.planned, &r.actual})
      for (auto& p : *path) p.t_s *= lasts_s / r.actual.back().t_s;
    r.actual.back().t_s = lasts_s;
    expect_words_within(height_view(r));
    AxisResult x{.name = "X", .measured = true};
    for (const double t_s : {0., 0.5 * lasts_s, lasts_s}) x.over_time.push_back({t_s, 0.01, 0.05});
    expect_words_within(following_view(x));
  }
}

TEST(Report, a_failure_shows_message_place_remedy_and_what_was_cut) {
  const auto page = report_page(made_up_failure());
  for (const char* part :
       {"Failed", "What stopped the job", "G200", "DriveFault", "What to do:", "overvoltage &lt;bus&gt;", "dots[2][5]",
        "not found", "contrast 4 below 20", "not comparable", "needle met C7 capacitor"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
}

TEST(Report, names_from_outside_cannot_become_markup) {
  const std::string evil = "<script>alert(1)</script>\"onload='x";
  auto r = made_up_failure();
  r.job = r.recipe_name = r.recipe_file = r.machine_name = r.bus = r.placement = r.started = evil;
  for (auto& m : r.marks) m.name = m.reason = evil;
  for (auto& t : r.touches) t.name = evil;
  for (auto& d : r.deposits) d.id = d.kind = evil;
  for (auto& p : r.drawing.parts) p.name = evil;
  for (auto& a : r.axes) a.name = evil;
  for (auto& e : r.errors) e.message = e.where = evil;
  for (auto& c : r.collisions) c.moving = c.standing = evil;
  for (auto& f : r.environment) f.name = f.value = evil;
  r.interrupted = r.events = {evil};
  for (auto& b : r.drawing.bodies) b.body.name = evil;
  const auto page = report_page(r);
  EXPECT_EQ(page.find("<script>alert"), std::string::npos);
  EXPECT_EQ(markup_of(page).find("\"onload="), std::string::npos);
}

TEST(Report, a_deposit_on_no_feature_is_no_error_of_0_and_is_counted) {
  auto r = made_up_job();
  const auto before = deposit_figures(r);
  r.deposits.push_back({.id = "", .kind = "bead", .nominal_mm = {}, .board_mm = {{1, 1, 5}, {2, 1, 5}}, .gap_mm = 5});
  const auto f = deposit_figures(r);
  EXPECT_EQ(f.strays, 1u);
  EXPECT_EQ(f.worst->id, before.worst->id);
  EXPECT_EQ(f.worst_gap_mm, before.worst_gap_mm) << "no gap was asked for there";
  EXPECT_NE(report_page(r).find("deposits on no feature"), std::string::npos);
  EXPECT_TRUE(to_json(r).at("deposits").back().at("error_mm").is_null());
}

TEST(Report, collisions_stand_on_the_time_of_the_height_plot) {
  auto r = made_up_job();
  const double last_s = r.actual.back().t_s;
  r.collisions.push_back({.moving = "needle", .standing = "U3", .at = {}, .t_s = last_s});
  const auto plot = height_view(r);
  EXPECT_NE(plot.find("<line x1=\"992.0\""), std::string::npos) << "a collision at the end stands at the right edge";
}

TEST(Report, following_error_stands_beside_its_window) {
  const auto page = report_page(made_up_job());
  EXPECT_NE(page.find("<td>X</td><td class=\"r\">12.3 µm</td>"), std::string::npos);
  EXPECT_NE(page.find("500.0 µm</td><td class=\"r\">5.500 mm</td>"), std::string::npos);
}

TEST(Report, virtual_time_has_no_times_of_the_loop) {
  auto r = made_up_job();
  r.cycles.virtual_time = true;
  EXPECT_EQ(report_page(r).find("99.9 %"), std::string::npos);
  r.cycles.virtual_time = false;
  EXPECT_NE(report_page(r).find("99.9 %"), std::string::npos);
}

/// The words of all cells in the row of a table that begins with this one.
std::string row_of(const std::string& page, const std::string& first) {
  const auto from = page.find("<td>" + first + "</td>");
  if (from == std::string::npos) return {};
  std::string out;
  bool markup = true;
  for (const char c : page.substr(from, page.find("</tr>", from) - from)) {
    if (c == '<') markup = true;
    if (!markup) out += c;
    if (c == '>') markup = false, out += out.empty() || out.back() == '|' ? "" : "|";
  }
  return out;
}

TEST(Report, what_was_forecast_stands_beside_what_it_took) {
  auto r = made_up_job();
  r.steps = {{.what = "mark 'lower left'", .predicted_s = 0.8, .actual_s = 0.812, .done = true},
             {.what = "dispense 30 features", .predicted_s = 20, .actual_s = 26.5, .disturbed = true, .done = true},
             {.what = "purge", .predicted_s = {}, .actual_s = 1.5, .done = true},
             {.what = "park", .predicted_s = 1.25}};
  r.feature_names = {"dam", "seam"};
  r.feature_times = {{.predicted = {.travel_s = 0.4, .on_it_s = 2}, .actual = {.travel_s = 0.4, .on_it_s = 2.001}},
                     {.predicted = {.travel_s = 0.3, .on_it_s = 5}, .actual = {.travel_s = 0.3, .on_it_s = 6}}};
  const std::string page = report_page(r);
  EXPECT_EQ(row_of(page, "mark &#39;lower left&#39;"), "mark &#39;lower left&#39;|0.800|0.812|+0.012|");
  EXPECT_EQ(row_of(page, "dispense 30 features"), "dispense 30 features|20.000|26.500|disturbed|") << "not compared";
  EXPECT_EQ(row_of(page, "purge"), "purge|1.500|") << "not forecast";
  EXPECT_EQ(row_of(page, "park"), "park|1.250|–|not begun|");
  EXPECT_EQ(row_of(page, "dam"), "dam|0.400|0.400|2.001|2.000|");
  EXPECT_LT(page.find("<td>seam</td>"), page.find("<td>dam</td>")) << "the slowest first";
}

TEST(Report, the_steadiness_of_beads_is_told_with_the_least_steady_first) {
  auto r = made_up_job();
  const auto beads =
      std::find_if(r.deposits.begin(), r.deposits.end(), [](const Deposit& d) { return d.kind == "bead"; });
  ASSERT_GE(r.deposits.end() - beads, 2);
  beads[0].speed = {
      .asked_mm_s = 20, .least_mm_s = 19.5, .most_mm_s = 20.1, .within_5_percent = 1, .volume_per_length = 1};
  beads[1].speed = {
      .asked_mm_s = 20, .least_mm_s = 8, .most_mm_s = 20.1, .within_5_percent = 0.8, .volume_per_length = 1.25};
  const std::string page = report_page(r);
  const auto from = page.find("How steadily");
  ASSERT_NE(from, std::string::npos);
  EXPECT_EQ(row_of(page.substr(from), beads[1].id), beads[1].id + "|20.0|8.00|20.10|80.0 %|125.0 %|");
  EXPECT_LT(page.find(beads[1].id, from), page.find(beads[0].id, from));
}

TEST(Report, what_was_asked_and_where_it_ended_are_drawn_of_a_job_that_did_not_finish) {
  auto r = made_up_job();
  const std::string whole = report_page(r);
  EXPECT_EQ(whole.find("class=\"asked"), std::string::npos);
  EXPECT_EQ(whole.find("the job ended here"), std::string::npos);
  r.features_done = 3, r.exit_code = ExitCode::Interrupted;
  const std::string page = report_page(r);
  EXPECT_NE(page.find("class=\"asked"), std::string::npos);
  EXPECT_NE(page.find("the job ended here"), std::string::npos);
}

/// As in the summary, where it is null: a number that is none looks like another job's.
TEST(Report, a_job_without_a_tick_has_no_setpoint_hash) {
  EXPECT_NE(report_page(made_up_job()).find("setpoint hash"), std::string::npos);
  EXPECT_EQ(report_page(JobResult{}).find("setpoint hash"), std::string::npos);
}

TEST(Report, features_are_numbered_in_the_order_in_which_they_were_dispensed) {
  auto r = made_up_job();
  r.feature_names = {"first_written", "second_written"};
  r.feature_order = {1, 0};
  const std::string page = report_page(r);
  EXPECT_NE(page.find(">1 second_written<"), std::string::npos);
  EXPECT_NE(page.find(">2 first_written<"), std::string::npos);
}

/// The judge keeps every sample.
TEST(EnvelopeLine, keeps_the_worst_part_of_its_limit_whatever_the_length) {
  for (const int n : {10, 1000, 400'000}) {
    EnvelopeLine line;
    double worst = 0, worst_at = 0;
    for (int i = 0; i < n; ++i) {
      const double t = i * 0.001, limit = 1 + (i % 13), value = limit * std::abs(std::sin(i * 12.9898)) * 0.9;
      line.add(t, value, limit);
      if (value / limit > worst) worst = value / limit, worst_at = t;
    }
    EXPECT_LE(line.points().size(), EnvelopeLine::kMost);
    double kept = 0, kept_at = 0;
    for (const EnvelopePoint& p : line.points())
      if (p.value / p.limit > kept) kept = p.value / p.limit, kept_at = p.t_s;
    EXPECT_DOUBLE_EQ(kept, worst) << n;
    EXPECT_LE(kept_at, worst_at + 1e-9);
    EXPECT_GE(kept_at + line.stretch_s(), worst_at) << n;
  }
}

TEST(Report, of_a_hundred_thousand_dots_opens) {
  auto r = made_up_job();
  const auto dot = r.deposits.front();
  const auto points = r.actual;
  while (r.deposits.size() < 100'000) r.deposits.push_back(dot);
  double t_s = points.back().t_s;
  while (r.actual.size() < 400'000)
    for (auto p : points) p.t_s = t_s += 0.01, p.block = points.back().block, r.actual.push_back(p);
  r.planned = r.actual;
  EXPECT_LT(report_page(r).size(), 5'000'000u);
}

TEST(Polyline, an_envelope_keeps_peaks_and_thinning_keeps_ends) {
  std::vector<Vec2> saw;
  for (int i = 0; i < 10000; ++i) saw.push_back({i * 0.01, i % 7 == 3 ? 50.0 : i == 4321 ? -20.0 : 0.0});
  const auto kept = envelope(saw);
  EXPECT_LE(kept.size(), 4u * 201);
  const auto [low, high] = std::minmax_element(kept.begin(), kept.end(), [](Vec2 a, Vec2 b) { return a.y < b.y; });
  EXPECT_EQ(low->y, -20);
  EXPECT_EQ(high->y, 50);
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end(), [](Vec2 a, Vec2 b) { return a.x < b.x; }));
  const auto thin = thinned(saw, 50);
  EXPECT_LE(thin.size(), 50u);
  EXPECT_EQ(thin.front(), saw.front());
  EXPECT_EQ(thin.back(), saw.back());
  EXPECT_TRUE(thinned({}, 50).empty());
}

TEST(Report, is_well_formed_and_survives_an_empty_job_and_numbers_that_are_none) {
  ASSERT_EQ(std::system("xmllint --version >/dev/null 2>&1"), 0) << "scripts/setup installs it";
  const Folder folder;
  auto broken = made_up_failure();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  broken.predicted_s = broken.actual_s = broken.offset_rms_mm = nan;
  broken.minimum_clearance.others->distance_mm = nan;
  broken.actual[5].head.z = nan;
  broken.deposits[3].error_mm = nan;
  broken.marks[1].residual_mm = nan;
  int i = 0;
  for (const auto& r : {JobResult{}, made_up_job(), made_up_failure(), broken}) {
    const auto path = folder.path + "/" + std::to_string(i++);
    ASSERT_TRUE(write_report(path, r));
    EXPECT_EQ(markup_of(content(path + "/report.html")).find("nan"), std::string::npos);
    // libxml2's HTML parser is the judge of the markup; it does not know HTML 5's elements by name.
    const auto judge =
        "xmllint --html --noout " + path + "/report.html 2>&1 | grep 'parser error' | grep -v 'Tag .* invalid'";
    EXPECT_NE(std::system(judge.c_str()), 0) << "see the lines above";
  }
}

/// With GANTRY_REPORT_SAMPLE=DIR the made-up reports stay there, to be looked at.
TEST(Report, a_job_s_folder_is_made_when_it_is_missing) {
  const Folder folder;
  const char* keep = std::getenv("GANTRY_REPORT_SAMPLE");
  const std::string dir = keep != nullptr ? keep : folder.path;
  ASSERT_TRUE(write_report(dir + "/jobs/done", made_up_job()));
  ASSERT_TRUE(write_report(dir + "/jobs/failed", made_up_failure()));
  EXPECT_FALSE(content(dir + "/jobs/failed/report.html").empty());
}

}  // namespace
}  // namespace gantry::record
