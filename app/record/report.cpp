#include "app/record/report.hpp"

#include <cctype>
#include <fmt/format.h>
#include <set>

#include "app/record/deposit_figures.hpp"
#include "app/record/html.hpp"
#include "app/record/report_geometry.hpp"
#include "app/record/report_plots.hpp"
#include "app/record/report_style.hpp"
#include "app/record/report_tables.hpp"
#include "app/record/scene_section.hpp"
#include "app/record/summary.hpp"
#include "app/record/write_file.hpp"

namespace gantry::record {
namespace {

std::string board_section(const JobResult& r) {
  const auto view = top_view(r);
  if (view.empty()) return {};
  std::string legend = "<div class=\"legend\">";
  const auto sample = [&](const char* drawing, const char* words) {
    legend += fmt::format("<span><svg viewBox=\"0 0 26 14\" aria-hidden=\"true\">{}</svg>{}</span>", drawing, words);
  };
  sample(R"(<line x1="1" y1="7" x2="25" y2="7" class="planned"/>)", "planned");
  sample(R"(<line x1="1" y1="7" x2="25" y2="7" class="actual"/>)", "actual");
  if (r.features_done < r.features_total)
    sample(R"(<line x1="1" y1="7" x2="25" y2="7" class="asked"/>)", "asked for by the recipe");
  if (ended_early(r) && !r.actual.empty())
    sample(R"(<circle cx="13" cy="7" r="6" class="stopped"/>)", "where the job ended");
  sample(R"(<circle cx="13" cy="7" r="5" class="mark"/><line x1="13" y1="7" x2="22" y2="3" class="residual"/>)",
         fmt::format("mark, residual x {:.0f}", residual_magnification(r)).c_str());
  sample(R"(<path d="M8 3 18 3 13 11Z" class="touch"/>)", "touched, height in mm");
  if (r.has_world)
    legend += "<span>deposit, error 0<span class=\"scale\"></span>what its tolerances allow, beyond it red</span>";
  else
    sample(R"(<line x1="3" y1="7" x2="23" y2="7" class="bead" stroke-width="6"/>)", "valve open");
  if (!r.collisions.empty())
    sample(R"(<circle cx="13" cy="7" r="6" class="hit"/><line x1="10" y1="4" x2="16" y2="10" class="cross"/>)",
           "collision");
  std::string hits;
  for (const auto& c : r.collisions)
    hits += fmt::format("<p class=\"bad\">{} met {} at {} s, at {}, {}, {} mm (machine).</p>", html::text(c.moving),
                        html::text(c.standing), html::number(c.t_s, 3), html::number(c.at.x, 2),
                        html::number(c.at.y, 2), html::number(c.at.z, 2));
  return "<section><h2>The board from above, mm</h2>" + view + legend + "</div>" + hits + "</section>\n";
}

std::string time_section(const JobResult& r) {
  const auto view = height_view(r);
  if (view.empty()) return {};
  return "<section><h2>Height of the tool over the board's nominal top, mm</h2>" + view +
         "<p class=\"note\">Time since the job began, as events and collisions count it; homing comes first. Green: "
         "the "
         "valve is open.</p></section>\n";
}

/// A name that is safe as a file's, different for different marks.
std::string file_name(const std::string& name, std::set<std::string>& taken) {
  std::string safe;
  for (const char c : name.substr(0, 60)) safe += std::isalnum(static_cast<unsigned char>(c)) ? c : '-';
  if (safe.empty()) safe = "mark";
  std::string unique = safe;
  for (int i = 2; !taken.insert(unique).second; ++i) unique = fmt::format("{}-{}", safe, i);
  return unique;
}

}  // namespace

std::string report_page(const JobResult& r) {
  const SceneSection scene = scene_section(r);
  std::string page = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>{}: {}</title><style>{}</style>{}"
      "</head><body><main>\n",
      html::text(r.recipe_name.empty() ? r.job : r.recipe_name), result_word(r), kStyle, scene.head);
  page += headline(r);
  page += tiles(r);
  page += error_section(r);
  page += defect_section(r);
  page += finish_section(r);
  page += scene.section;
  page += board_section(r);
  page += time_section(r);
  page += joined_section(r);
  page += mark_section(r);
  page += deposit_section(r);
  page += length_section(r);
  page += speed_section(r);
  page += times_section(r);
  page += recipe_section(r);
  page += "<div class=\"columns\">" + height_section(r) + following_section(r) + cycle_section(r) + fact_section(r) +
          "</div>\n";
  page += operator_section(r);
  page += event_section(r);
  return page + "</main>" + scene.scripts + "</body></html>\n";
}

Result<void> write_report(const std::string& dir, const JobResult& r) {
  return write_file(dir + "/report.html", report_page(r));
}

std::vector<std::string> image_names(const JobResult& r) {
  std::set<std::string> taken;
  std::vector<std::string> names;
  for (const MarkResult& m : r.marks)
    names.push_back(m.png.empty() ? "" : "marks/" + file_name(m.name, taken) + ".png");
  return names;
}

Result<void> write_image(const std::string& dir, const std::string& name, const MarkResult& mark) {
  return write_file(dir + "/" + name, {reinterpret_cast<const char*>(mark.png.data()), mark.png.size()});
}

}  // namespace gantry::record
