#include "core/sha256.hpp"

#include <gtest/gtest.h>

namespace gantry {
namespace {

// NIST, "Examples with Intermediate Values" for SHA-256: one block, two blocks; and the empty message of the CAVP
// vectors.
TEST(Sha256, agrees_with_the_examples_of_the_standard) {
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256_hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(Sha256, of_pieces_is_that_of_the_whole) {
  Sha256 hash;
  for (const char* piece : {"abcdbcdecdefdefgefghfghighi", "", "jhijkijkljklmklmnlmnomnopnop", "q"}) hash.add(piece);
  EXPECT_EQ(hash.hex(), "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Sha256, a_file_that_is_not_there_has_none) { EXPECT_EQ(sha256_of_file("/nothing/there"), ""); }

}  // namespace
}  // namespace gantry
