#include "config/fields.hpp"

#include <gtest/gtest.h>
