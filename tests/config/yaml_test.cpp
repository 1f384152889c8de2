#include "config/yaml.hpp"

#include <gtest/gtest.h>
