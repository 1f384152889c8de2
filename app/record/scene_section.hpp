// The section of the report that shows the scene in three dimensions, and what a page with scripts needs around it.
//   const auto scene = scene_section(result);   head += scene.head;   page += scene.section;   ...   page +=
//   scene.scripts;
// Without WebGL or scripts a sentence stands in its place.
#pragma once
#include <string>

#include "app/record/job_result.hpp"

namespace gantry::record {

struct SceneSection {
  std::string head;     ///< style and the page's security policy: nothing is fetched, and only these scripts run
  std::string section;  ///< empty when there is nothing to draw; then all are
  std::string scripts;  ///< data, library and script, for the end of the page
};

SceneSection scene_section(const JobResult& result);

/// JSON that may stand inside a script element: no text in it can end the element.
std::string inside_script(const std::string& json);

}  // namespace gantry::record
