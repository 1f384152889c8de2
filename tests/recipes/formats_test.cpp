// Schemas and docs say what the parser does.
#include <gtest/gtest.h>

#include "config/yaml.hpp"
#include "tests/recipes/made_files.hpp"

namespace gantry {
namespace {

TEST(Formats, committed_schemas_and_tables_are_what_the_parser_reads) {
  for (const MadeFile& file : made_files())
    EXPECT_TRUE(config::read_text_file(std::string(GANTRY_SOURCE_DIR "/") + file.path).value_or("") == file.text)
        << file.path << " is out of date: run scripts/docs";
}

}  // namespace
}  // namespace gantry
