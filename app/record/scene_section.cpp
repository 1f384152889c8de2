#include "app/record/scene_section.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <set>

#include "app/record/html.hpp"
#include "app/record/scene_picture.hpp"
#include "core/sha256.hpp"
#include "scene_assets.hpp"

namespace gantry::record {
namespace {

/// A hash in hex as a security policy wants it.
std::string policy_hash(std::string_view hex) {
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes.push_back(static_cast<std::byte>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16)));
  return "'sha256-" + html::base64(bytes) + "'";
}

/// An entry of the legend that shows and hides what it names. `css`: the colours of the page, of the fill and the edge.
std::string legend_entry(const char* layer, const char* words, const char* css, bool line = false) {
  const auto style = line ? fmt::format("border-color:var(--{})", css)
                          : fmt::format("background:var(--{0});border-color:var(--{0}-edge)", css);
  return fmt::format(
      R"(<label><input type="checkbox" checked="checked" data-layer="{}"/><i class="{}" style="{}"></i>{}</label>)",
      layer, line ? "line" : "", style, words);
}

std::string legend(const ScenePicture& p) {
  using Role = DrawnBody::Role;
  const auto has = [&](Role role) {
    return std::any_of(p.bodies.begin(), p.bodies.end(), [&](const DrawnBody& b) { return b.role == role; });
  };
  std::string out = "<div class=\"legend\">";
  if (has(Role::Machine)) out += legend_entry("machine", "machine", "scene-machine");
  if (has(Role::Fixture)) out += legend_entry("fixture", "fixtures", "scene-fixture");
  if (has(Role::Board)) out += legend_entry("board", "board", "scene-board");
  if (has(Role::Part)) out += legend_entry("part", "parts", "scene-part");
  if (has(Role::Head)) out += legend_entry("head", "head", "scene-head");
  if (has(Role::Zone)) out += legend_entry("zone", "zones to keep out of", "scene-zone");
  if (!p.lines.travel.empty()) out += legend_entry("travel", "path of the tools", "scene-travel", true);
  if (!p.lines.beads.empty() || !p.lines.dots.empty()) out += legend_entry("dispensed", "valve open", "bead", true);
  if (!p.asked.beads.empty() || !p.asked.dots.empty())
    out += legend_entry("asked", "what the recipe asks for", "scene-asked", true);
  if (!p.spots.empty()) out += legend_entry("spots", "marks (ring), touches (triangle)", "accent", true);
  return out + "</div>";
}

/// What is not drawn in full.
std::string bounds(const ScenePicture& p) {
  std::string out;
  if (!p.lines.travel.empty())
    out += fmt::format(" The path is drawn to within {} mm.", html::number(p.lines.within_mm, 2));
  const auto part = [&](const char* what, std::size_t every) {
    if (every > 1) out += fmt::format(" Of the {}, one in {} is drawn.", what, every);
  };
  part("beads", p.lines.every_bead), part("dots", p.lines.every_dot);
  part("beads that the recipe asks for", p.asked.every_bead), part("dots that it asks for", p.asked.every_dot);
  return out;
}

}  // namespace

std::string inside_script(const std::string& json) {
  std::string out;
  out.reserve(json.size());
  for (const char c : json)
    if (c == '<' || c == '>' || c == '&')
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    else
      out += c;
  return out;
}

SceneSection scene_section(const JobResult& r) {
  const ScenePicture picture = scene_picture(r);
  if (picture.bodies.empty() && picture.lines.travel.empty()) return {};
  const std::string script = std::string(kBodiesScript) + std::string(kSceneScript);

  SceneSection out;
  out.head = fmt::format(
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
      "style-src 'unsafe-inline'; script-src {} {}; base-uri 'none'; form-action 'none'\"/><style>{}</style>",
      policy_hash(sha256_hex(script)), policy_hash(kThreeSha256), kSceneStyle);

  out.section =
      "<section><h2>The scene, mm</h2>"
      "<p class=\"note\" id=\"scene-still\">The scene in three dimensions needs a browser with scripts and WebGL. The "
      "board from above shows board, parts and paths.</p>"
      "<div id=\"scene-view\" hidden=\"hidden\"><div class=\"scene-bar\">"
      "<button type=\"button\" data-side=\"space\">3-D</button><button type=\"button\" data-side=\"top\">top</button>"
      "<button type=\"button\" data-side=\"front\">front</button><button type=\"button\" "
      "data-side=\"side\">side</button>"
      "<button type=\"button\" id=\"scene-whole\">all</button><button type=\"button\" id=\"scene-close\">close "
      "up</button>"
      "<label>head: <select id=\"scene-pose\"></select></label></div>"
      "<div id=\"scene-stage\"><img id=\"scene-shot\" alt=\"\" src=\"data:,\"/></div><p id=\"scene-words\"></p>" +
      legend(picture) +
      "<p class=\"note\">Drag to turn, with the right button or two fingers to move; wheel or two "
      "fingers zoom once it was taken hold of. Bodies show their names." +
      bounds(picture) + "</p></div></section>\n";

  const auto dumped = to_json(picture).dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
  out.scripts = fmt::format(
      "<script type=\"application/json\" id=\"scene-data\">{}</script>\n<!--\n{}-->\n"
      "<script type=\"text/plain\" id=\"scene-library\">{}</script>\n<script>{}</script>\n",
      inside_script(dumped), kThreeLicence, kThree, script);
  return out;
}

}  // namespace gantry::record
