// SDO transfers that need more than one mailbox (ETG.1000.6, 5.6.2.3 to 5.6.2.6), and what the server makes of rubbish.
#include "sim/objects/coe_server.hpp"

#include <gtest/gtest.h>
#include <random>
#include <string>

#include "tests/sim/machines.hpp"
#include "tests/sim/raw_master.hpp"

namespace gantry::sim::test {
namespace {

struct Server : ::testing::Test {
  Server() {
    profile_.title = "a name that does not fit into one mailbox of thirty-two bytes, nor into two of them";
    objects = std::make_unique<ObjectDictionary>(profile_, 7u);
    server = std::make_unique<CoeServer>(*objects, 32);
  }
  /// CoE in, CoE out; empty: no answer.
  Raw ask(const Raw& coe) {
    counter = static_cast<std::uint8_t>(counter % 7 + 1);
    Raw m = bytes(coe.size(), 2) + bytes(0, 2) + Raw{0, static_cast<std::uint8_t>(3 | counter << 4)} + coe;
    m.resize(std::max<std::size_t>(m.size(), 32));
    server->take(std::as_bytes(std::span(m)), true);
    if (!server->waiting()) return {};
    const auto reply = server->next();
    EXPECT_LE(reply.size(), 32u);
    Raw out;
    for (const auto b : reply) out.push_back(std::to_integer<std::uint8_t>(b));
    EXPECT_EQ(value(out, 0, 2), out.size() - 6);
    EXPECT_NE(out[5] >> 4, last_reply_counter);
    last_reply_counter = out[5] >> 4;
    return Raw(out.begin() + 6, out.end());
  }
  config::StationProfile profile_ = profile("drives/id286.yaml");
  std::unique_ptr<ObjectDictionary> objects;
  std::unique_ptr<CoeServer> server;
  std::uint8_t counter = 0;
  int last_reply_counter = -1;
};

TEST_F(Server, uploads_a_long_string_in_segments) {
  Raw reply = ask(bytes(0x2000, 2) + Raw{0x40, 0x08, 0x10, 0} + bytes(0, 4));
  ASSERT_EQ(reply[2], 0x41);
  EXPECT_EQ(value(reply, 6, 4), profile_.title.size());
  std::string text(reply.begin() + 10, reply.end());
  bool toggle = false;
  for (bool last = false; !last;) {
    reply = ask(bytes(0x2000, 2) + Raw{static_cast<std::uint8_t>(0x60 | (toggle ? 0x10 : 0))} + Raw(7));
    ASSERT_GE(reply.size(), 10u);
    EXPECT_EQ(reply[2] & 0xF0, toggle ? 0x10 : 0x00);
    last = (reply[2] & 1) != 0;
    const std::size_t unused = reply.size() == 10 ? reply[2] >> 1 & 7u : 0u;
    text.append(reply.begin() + 3, reply.end() - static_cast<std::ptrdiff_t>(unused));
    toggle = !toggle;
  }
  EXPECT_EQ(text, profile_.title);
}

TEST_F(Server, a_toggle_that_does_not_change_aborts_the_upload) {
  ask(bytes(0x2000, 2) + Raw{0x40, 0x08, 0x10, 0} + bytes(0, 4));
  ask(bytes(0x2000, 2) + Raw{0x60} + Raw(7));
  const Raw reply = ask(bytes(0x2000, 2) + Raw{0x60} + Raw(7));
  EXPECT_EQ(reply[2], 0x80);
  EXPECT_EQ(value(reply, 3, 2), 0x1008u);
  EXPECT_EQ(value(reply, 6, 4), 0x05030000u);
}

TEST_F(Server, downloads_in_segments) {
  EXPECT_EQ(ask(bytes(0x2000, 2) + Raw{0x21, 0x7A, 0x60, 0} + bytes(4, 4))[2], 0x60);  // normal, no data yet
  EXPECT_EQ(ask(bytes(0x2000, 2) + Raw{0x0A, 0x11, 0x22} + Raw(5))[2], 0x20);          // 2 bytes: 7 - 5 unused
  EXPECT_EQ(ask(bytes(0x2000, 2) + Raw{0x1B, 0x33, 0x44} + Raw(5))[2], 0x30);          // the last 2
  EXPECT_EQ(objects->value({0x607A, 0}), 0x44332211);
}

TEST_F(Server, a_download_must_be_as_long_as_it_said) {
  ask(bytes(0x2000, 2) + Raw{0x21, 0x7A, 0x60, 0} + bytes(4, 4));
  EXPECT_EQ(value(ask(bytes(0x2000, 2) + Raw{0x0B, 0x11, 0x22} + Raw(5)), 6, 4), 0x06070013u);
  ask(bytes(0x2000, 2) + Raw{0x21, 0x7A, 0x60, 0} + bytes(4, 4));
  EXPECT_EQ(value(ask(bytes(0x2000, 2) + Raw{0x01} + Raw(7)), 6, 4), 0x06070012u);
  EXPECT_EQ(objects->value({0x607A, 0}), 0);
}

TEST_F(Server, a_normal_download_with_its_data_is_one_mailbox) {
  EXPECT_EQ(ask(bytes(0x2000, 2) + Raw{0x21, 0x7A, 0x60, 0} + bytes(4, 4) + bytes(0xFFFFFFFE, 4))[2], 0x60);
  EXPECT_EQ(objects->value({0x607A, 0}), -2);
}

// --- Complete access (ETG.1000.6, 5.6.2.1): sub 0 takes two bytes, the rest follows without gaps

TEST_F(Server, uploads_an_index_as_a_whole) {
  const Raw reply = ask(bytes(0x2000, 2) + Raw{0x50, 0x18, 0x10, 0} + bytes(0, 4));
  ASSERT_EQ(reply[2], 0x51);
  EXPECT_EQ(value(reply, 6, 4), 18u);
  EXPECT_EQ(value(reply, 10, 2), 4u);
  EXPECT_EQ(value(reply, 12, 4), profile_.identity.vendor);
  const Raw rest = ask(bytes(0x2000, 2) + Raw{0x60} + Raw(7));
  EXPECT_EQ(rest[2] & 1, 1);
  const Raw from_one = ask(bytes(0x2000, 2) + Raw{0x50, 0x12, 0x1C, 1} + bytes(0, 4));
  EXPECT_EQ(from_one[2] & 0xF3, 0x53);  // one assigned PDO: two bytes, expedited
  EXPECT_EQ(value(from_one, 6, 2), 0x1600u);
  EXPECT_EQ(value(ask(bytes(0x2000, 2) + Raw{0x50, 0x18, 0x10, 2} + bytes(0, 4)), 6, 4), 0x06010000u);
  EXPECT_EQ(value(ask(bytes(0x2000, 2) + Raw{0x50, 0x00, 0x10, 0} + bytes(0, 4)), 6, 4), 0x06010000u);
}

TEST_F(Server, takes_a_mapping_as_a_whole_or_not_at_all) {
  // Nothing assigned, then 1600h with two entries.
  EXPECT_EQ(ask(bytes(0x2000, 2) + Raw{0x3B, 0x12, 0x1C, 0} + bytes(0, 4))[2], 0x70);
  const Raw good = bytes(2, 2) + bytes(0x60400010, 4) + bytes(0x607A0020, 4);
  EXPECT_EQ(ask(bytes(0x2000, 2) + Raw{0x31, 0x00, 0x16, 0} + bytes(good.size(), 4) + good)[2], 0x70);
  EXPECT_EQ(objects->value({0x1600, 0}), 2);
  EXPECT_EQ(objects->value({0x1600, 2}), 0x607A0020);
  const Raw bad = bytes(2, 2) + bytes(0x60600008, 4) + bytes(0x60410010, 4);  // 6041h is no output
  EXPECT_EQ(value(ask(bytes(0x2000, 2) + Raw{0x31, 0x00, 0x16, 0} + bytes(bad.size(), 4) + bad), 6, 4), 0x06040041u);
  EXPECT_EQ(objects->value({0x1600, 0}), 2);
  EXPECT_EQ(objects->value({0x1600, 1}), 0x60400010);
  const Raw assign = bytes(1, 2) + bytes(0x1600, 2);
  EXPECT_EQ(ask(bytes(0x2000, 2) + Raw{0x33, 0x12, 0x1C, 0} + assign)[2], 0x70);
  EXPECT_EQ(objects->value({0x1C12, 0}), 1);
}

// --- SDO information (ETG.1000.6, 5.6.3)

struct Information : Server {
  /// All fragments of an answer, without their headers.
  Raw inform(std::uint8_t opcode, const Raw& body) {
    Raw reply = ask(bytes(0x8000, 2) + Raw{opcode, 0, 0, 0} + body);
    Raw out;
    for (;;) {
      EXPECT_EQ(value(reply, 0, 2), 0x8000u);
      answered = reply[2] & 0x7F;
      const auto left = value(reply, 4, 2);
      EXPECT_EQ((reply[2] & 0x80) != 0, left > 0);
      out.insert(out.end(), reply.begin() + 6, reply.end());
      if (left == 0) return out;
      if (!server->waiting()) {
        ADD_FAILURE() << "a fragment is missing";
        return out;
      }
      const auto next = server->next();
      EXPECT_LE(next.size(), 32u);
      reply.clear();
      for (const auto b : next) reply.push_back(std::to_integer<std::uint8_t>(b));
      EXPECT_NE(reply[5] >> 4, last_reply_counter);
      last_reply_counter = reply[5] >> 4;
      reply.erase(reply.begin(), reply.begin() + 6);
      EXPECT_EQ(value(reply, 4, 2) + 1, left);
    }
  }
  std::vector<unsigned> list(unsigned type) {
    const Raw out = inform(1, bytes(type, 2));
    EXPECT_EQ(value(out, 0, 2), type);
    std::vector<unsigned> indices;
    for (std::size_t i = 2; i < out.size(); i += 2) indices.push_back(static_cast<unsigned>(value(out, i, 2)));
    return indices;
  }
  int answered = 0;
};

TEST_F(Information, lists_every_object_in_order_and_counts_the_lists) {
  const auto lengths = list(0);
  ASSERT_EQ(lengths.size(), 5u);
  std::vector<unsigned> all;
  for (const Object& o : objects->all())
    if (all.empty() || all.back() != o.address.index) all.push_back(o.address.index);
  EXPECT_EQ(list(1), all);
  for (unsigned type = 1; type <= 5; ++type) EXPECT_EQ(list(type).size(), lengths[type - 1]) << type;
  const auto rx = list(2), tx = list(3);
  EXPECT_NE(std::find(rx.begin(), rx.end(), 0x607Au), rx.end());
  EXPECT_EQ(std::find(rx.begin(), rx.end(), 0x6041u), rx.end());
  EXPECT_NE(std::find(tx.begin(), tx.end(), 0x6041u), tx.end());
  EXPECT_EQ(answered, 2);
}

TEST_F(Information, describes_objects) {
  const Raw identity = inform(3, bytes(0x1018, 2));
  EXPECT_EQ(answered, 4);
  EXPECT_EQ(Raw(identity.begin(), identity.begin() + 6), (Raw{0x18, 0x10, 0x23, 0x00, 4, 9}));  // record IDENTITY
  const Raw target = inform(3, bytes(0x607A, 2));
  EXPECT_EQ(Raw(target.begin(), target.begin() + 6), (Raw{0x7A, 0x60, 0x04, 0x00, 0, 7}));  // INTEGER32, VAR
  EXPECT_EQ(std::string(target.begin() + 6, target.end()), "target position");
  const Raw assignment = inform(3, bytes(0x1C12, 2));
  EXPECT_EQ(assignment[2], 0x06);
  EXPECT_EQ(assignment[5], 8);  // ARRAY
  EXPECT_EQ(value(inform(3, bytes(0x5FFF, 2))), 0x06020000u);
  EXPECT_EQ(answered, 7);
}

TEST(Shapes, of_standard_objects_are_those_of_etg_1020_and_cia_402) {
  struct Row {
    std::uint16_t index;
    ObjectCode code;
    std::uint16_t type;  // 0x04 INTEGER32, 0x05..0x07 UNSIGNED8..32, 0x21 PDO mapping, 0x23 identity, 0x29 SYNC_PAR
    const char* name;
  };
  // Codes, types and names as an independent stack has them (the ETG's slave sample code: identity 23h with 4 entries,
  // 1C00h an array of UNSIGNED8, 1C12h of UNSIGNED16, 1C32h type 29h with 32); CiA 402-2 for the drive's.
  for (const char* file : {"drives/id286.yaml", "drives/amd530b.yaml", "drives/std402ec.yaml"}) {
    const auto drive = profile(file);
    const ObjectDictionary objects(drive, 1);
    for (const Row& row :
         {Row{0x1018, ObjectCode::Record, 0x23, "Identity object"},
          Row{0x10F1, ObjectCode::Record, 0x2A, "Error settings"},
          Row{0x1600, ObjectCode::Record, 0x21, "RxPDO mapping"},
          Row{0x1A00, ObjectCode::Record, 0x21, "TxPDO mapping"},
          Row{0x1C00, ObjectCode::Array, 0x05, "Sync manager type"},
          Row{0x1C12, ObjectCode::Array, 0x06, "RxPDO assign"}, Row{0x1C13, ObjectCode::Array, 0x06, "TxPDO assign"},
          Row{0x1C32, ObjectCode::Record, 0x29, "SM output parameter"},
          Row{0x1C33, ObjectCode::Record, 0x29, "SM input parameter"},
          Row{0x607A, ObjectCode::Var, 0x04, "target position"}, Row{0x6099, ObjectCode::Array, 0x07, "Homing speeds"},
          Row{0x60FE, ObjectCode::Array, 0x07, "Digital outputs"}}) {
      const auto shape = objects.shape(row.index);
      EXPECT_EQ(shape.code, row.code) << file << std::hex << row.index;
      EXPECT_EQ(shape.data_type, row.type) << file << std::hex << row.index;
      EXPECT_EQ(shape.name, row.name) << file << std::hex << row.index;
    }
    EXPECT_EQ(objects.index(0x1C32).back().address.sub, 32);
    EXPECT_EQ(objects.index(0x1018).back().address.sub, 4);
  }
  const auto two_axes = profile("drives/std402ec.yaml");
  EXPECT_EQ(ObjectDictionary(two_axes, 1).shape(0x6899).name, "Homing speeds");
  const auto id286 = profile("drives/id286.yaml");
  EXPECT_EQ(ObjectDictionary(id286, 1).shape(0x607D).name, "Software position limit");
  EXPECT_EQ(ObjectDictionary(id286, 1).shape(0x2190).name, "IN function");  // the vendor's: what its entries share
  const auto dio = profile("devices/dio16.yaml");
  EXPECT_EQ(ObjectDictionary(dio, 1).shape(0x6000).name, "inputs");
}

TEST_F(Information, describes_entries_with_what_is_asked_for) {
  const Raw method = inform(5, bytes(0x6098, 2) + Raw{0, 0x7F});
  EXPECT_EQ(answered, 6);
  EXPECT_EQ(value(method, 4, 2), 0x0002u);  // INTEGER8
  EXPECT_EQ(value(method, 6, 2), 8u);
  EXPECT_EQ(value(method, 8, 2) & 0x3Fu, 0x3Fu);  // read and write in all states
  EXPECT_EQ(method[3] & 0x70, 0x70);              // default, minimum, maximum: 21, 0, 100
  EXPECT_EQ(Raw(method.begin() + 10, method.begin() + 13), (Raw{21, 0, 100}));
  EXPECT_EQ(std::string(method.begin() + 13, method.end()), "homing method");
  const Raw status = inform(5, bytes(0x6041, 2) + Raw{0, 0x07});
  EXPECT_EQ(value(status, 8, 2) & 0xFFu, 0x87u);  // read only, in a TxPDO
  const Raw mapping = inform(5, bytes(0x1600, 2) + Raw{1, 0x07});
  EXPECT_EQ(value(mapping, 8, 2) & 0x3Fu, 0x0Fu);  // written in PRE_OP only
  EXPECT_EQ(value(inform(5, bytes(0x6098, 2) + Raw{9, 0})), 0x06090011u);
  EXPECT_EQ(value(inform(9, Raw(4))), 0x05040001u);
}

TEST_F(Server, drops_a_repeated_counter) {
  Raw m = bytes(10, 2) + bytes(0, 2) + Raw{0, 0x33} + bytes(0x2000, 2) + Raw{0x40, 0x00, 0x10, 0} + bytes(0, 4);
  server->take(std::as_bytes(std::span(m)), true);
  server->next();
  server->take(std::as_bytes(std::span(m)), true);
  EXPECT_FALSE(server->waiting());
  m[5] = 0x03;  // a counter of 0 is not counted
  server->take(std::as_bytes(std::span(m)), true);
  server->take(std::as_bytes(std::span(m)), true);
  server->next();
  EXPECT_TRUE(server->waiting());
}

TEST_F(Server, answers_rubbish_with_bounded_replies) {
  std::mt19937 random(99);
  for (int i = 0; i < 200'000; ++i) {
    Raw m(random() % 40);
    for (auto& b : m) b = static_cast<std::uint8_t>(random() % 4 == 0 ? random() : random() % 0x24);
    if (m.size() > 8 && random() % 2 == 0)
      m[0] = static_cast<std::uint8_t>(m.size() - 6), m[1] = 0, m[5] = 3, m[7] = 0x20;
    server->take(std::as_bytes(std::span(m)), random() % 2 == 0);
    while (server->waiting()) EXPECT_LE(server->next().size(), 32u);
  }
  SUCCEED() << "seed 99";
}

}  // namespace
}  // namespace gantry::sim::test
