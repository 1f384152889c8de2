// Orders as lines of JSON.
#include "app/desk/order_line.hpp"

#include <gtest/gtest.h>
#include <string>

namespace gantry::desk {
namespace {

Result<run::Order> parse_order(std::string_view line) { return read_request(line).order; }

bool is_urgent(std::string_view line) {
  const auto order = parse_order(line);
  return may_stop(line) && order && stop_kind(order->kind);
}

using run::OrderKind;

TEST(OrderLine, a_jog_is_one_line_of_json_and_back) {
  const run::Order order{.kind = OrderKind::Jog, .jog = {.by = {{"X", "10 mm"}, {"C", "-15 deg"}}, .speed = "20 mm/s"}};
  const std::string line = to_line(order);
  EXPECT_EQ(line, R"({"order":"jog","by":{"C":"-15 deg","X":"10 mm"},"speed":"20 mm/s"})");
  const auto read = parse_order(line);
  ASSERT_TRUE(read) << to_text(read.error());
  EXPECT_EQ(read->kind, OrderKind::Jog);
  EXPECT_EQ(read->jog.by, order.jog.by);
  EXPECT_EQ(read->jog.speed, order.jog.speed);
  for (const char* wrong : {R"({"order":"jog"})", R"({"order":"jog","by":{}})", R"({"order":"jog","by":["X","1 mm"]})",
                            R"({"order":"jog","by":{"X":10}})"}) {
    const auto refused = parse_order(wrong);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_NE(refused.error().message.find(R"({"X": "10 mm"})"), std::string::npos) << wrong;
  }
}

/// What is misspelt or of another type moves nothing: a jog at the speed that was not meant, an axis that was not
/// named.
TEST(OrderLine, a_key_that_is_not_meant_there_is_refused_by_name) {
  const struct {
    const char *line, *says;
  } kWrong[] = {
      {R"({"order":"jog","by":{"X":"10 mm"},"spee":"5 mm/s"})", "speed"},
      {R"({"order":"jog","by":{"X":"10 mm"},"speed":5})", R"("speed" of 'jog' is a text)"},
      {R"({"order":"home","axes":["X"]})", R"('home' has no key "axes")"},
      {R"({"order":"run","recipe":"a.yaml","dry":true})", R"("dry")"},
      {R"({"order":"run","recipe":["a.yaml"]})", R"("recipe" of 'run')"},
      {R"({"order":"run","recipe":"a.yaml","value":1})", R"("value")"},
      {R"({"order":"enable","recipe":"a.yaml"})", R"("recipe")"},
      {R"({"order":"override","value":"0.5"})", "0.01 to 2"},
  };
  for (const auto& [line, says] : kWrong) {
    const auto refused = parse_order(line);
    ASSERT_FALSE(refused) << line;
    EXPECT_NE(refused.error().message.find(says), std::string::npos) << refused.error().message;
  }
  for (const char* stop :
       {R"({"order":"abort","reason":"smoke"})", R"({"order":"hold","now":1})", R"({"order":"quit","recipe":7})"})
    EXPECT_TRUE(parse_order(stop)) << stop << ": a stop is taken whatever else is said";
}

/// Whoever gives it: what a command line may not say, a line of the socket may not, either. What stops is taken all the
/// same.
TEST(OrderLine, an_empty_serial_is_none_that_a_scanner_has_read) {
  for (const char* line :
       {R"({"order":"run","recipe":"/jobs/a.yaml","serial":""})", R"({"order":"part_removed","serial":""})"}) {
    const auto refused = parse_order(line);
    ASSERT_FALSE(refused) << line;
    EXPECT_NE(refused.error().message.find("\"serial\" is empty"), std::string::npos) << refused.error().message;
  }
  EXPECT_TRUE(parse_order(R"({"order":"part_removed"})"));
}

TEST(OrderLine, a_serial_that_steers_a_terminal_or_is_too_long_is_refused) {
  for (const char* order : {"run", "part_removed"})
    for (const std::string& serial :
         {std::string("S-1\nS-2"), std::string("S\x1b[31m"), std::string("S\u202e1"), std::string(129, '0')}) {
      nlohmann::json line{{"order", order}, {"serial", serial}};
      if (line["order"] == "run") line["recipe"] = "/jobs/board.yaml";
      const auto refused = parse_order(line.dump());
      ASSERT_FALSE(refused) << line.dump();
      EXPECT_EQ(refused.error().fault, Fault::Refused);
      EXPECT_NE(refused.error().message.find("\"serial\" "), std::string::npos) << refused.error().message;
      line["serial"] = std::string(128, '0');
      EXPECT_TRUE(parse_order(line.dump()));
      line["serial"] = "Prüfling 7/\xc2\xb5";
      EXPECT_TRUE(parse_order(line.dump()));
    }
  EXPECT_TRUE(parse_order(R"({"order":"abort","serial":"S\u001b[31m"})"));
}

/// A line controller branches on the board, also where its order was wrong.
TEST(OrderLine, an_order_that_is_refused_is_answered_by_its_name_and_a_job_with_its_board) {
  const auto answer = [](const char* line) { return answer_to(read_request(line), {{"ok", false}}); };
  for (const char* run : {R"({"order":"run","recipe":7})", R"({"order":"run","recipe":"a.yaml","serial":"S\u001b"})",
                          R"({"order":"run"})", R"({"order":"run","recipe":"a.yaml","dry":true,"id":4})"}) {
    EXPECT_EQ(answer(run).value("order", ""), "run") << run;
    EXPECT_EQ(answer(run).value("board", ""), "untouched") << run;
  }
  EXPECT_EQ(answer(R"({"order":"jog"})").value("order", ""), "jog");
  EXPECT_FALSE(answer(R"({"order":"jog"})").contains("board"));
  EXPECT_FALSE(answer(R"({"order":"fly"})").contains("order"));
  EXPECT_EQ(answer("{\"order\": \"abort\", \"x\": ").value("order", ""), "abort");
  EXPECT_EQ(answer_to(read_request(R"({"order":"run","recipe":"a.yaml"})"), {{"board", "whole"}})["board"], "whole");
}

std::string nested(int levels) {
  return std::string(static_cast<std::size_t>(levels), '[') + std::string(static_cast<std::size_t>(levels), ']');
}

/// The id is what a client calls its order: no reason to go on moving.
TEST(OrderLine, a_stop_is_obeyed_whatever_its_id_is_and_answered_without_one_that_is_none) {
  const std::string no_ids[] = {"\"" + std::string(200, 'x') + "\"", nested(20), nested(30'000),
                                "{\"a\":" + nested(60) + "}"};
  for (const auto& [name, kind] :
       {std::pair{"abort", OrderKind::Abort}, {"hold", OrderKind::Hold}, {"quit", OrderKind::Quit}})
    for (const std::string& id : no_ids) {
      const std::string line = std::string(R"({"id":)") + id + R"(,"order":")" + name + "\"}";
      SCOPED_TRACE(line.substr(0, 80));
      const Request request = read_request(line);
      ASSERT_TRUE(request.order) << to_text(request.order.error());
      EXPECT_EQ(request.order->kind, kind);
      const bool is_one = id == nested(20);  // 40 bytes
      EXPECT_EQ(request.id.is_null(), !is_one);
      EXPECT_TRUE(is_urgent(line));
    }
  for (const std::string& id : no_ids) {
    const Request other = read_request(R"({"order":"status","id":)" + id + "}");
    EXPECT_TRUE(other.id.is_null() == (id != nested(20)));
    EXPECT_EQ(other.order.has_value(), id == nested(20)) << id.substr(0, 50);
  }
}

/// A client that writes its reason in Latin-1, or whose line was cut, wants what it says first.
TEST(OrderLine, a_line_that_names_a_stop_stops_though_the_rest_of_it_is_no_json) {
  const std::string broken[] = {
      "{\"order\":\"abort\",\"reason\":\"Rauch \xFC"
      "ber der Platte\"}",
      "{\"reason\":\"\xFC\",\"order\" : \"abort\"}",
      R"({"order":"abort")",
      R"({"order":"abort","id":)",
      R"({"order":"abort","reason":"smoke)",
      R"({"order":"abort",})",
      R"({"order":"abort"}})",
      "{\"order\":\"abort\",\"reason\":\"two\tlines\"}"};
  for (const std::string& line : broken) {
    const Request request = read_request(line);
    ASSERT_TRUE(request.order) << line;
    EXPECT_EQ(request.order->kind, OrderKind::Abort) << line;
    EXPECT_TRUE(request.id.is_null());
    EXPECT_TRUE(is_urgent(line)) << line;
  }
  const auto held = parse_order(R"({"order":"hold","now":fal)");
  ASSERT_TRUE(held);
  EXPECT_EQ(held->kind, OrderKind::Hold);
  EXPECT_TRUE(held->now) << "whether it may wait cannot be read";
  for (const char* other : {R"({"order":"resume",})", R"({"order":"run","recipe":"abort)",
                            R"({"order":"status","why":"\"order\":\"abort\"")", R"(abort)", R"({"order":"aborted",)",
                            R"(["order":"abort")"}) {
    const auto read = parse_order(other);
    EXPECT_FALSE(read) << other;
    EXPECT_FALSE(is_urgent(other)) << other;
  }
}

TEST(OrderLine, a_stop_of_any_length_waits_for_nothing) {
  EXPECT_TRUE(is_urgent(R"({"order":"abort","reason":")" + std::string(20'000, 'x') + "\"}"));
  EXPECT_FALSE(is_urgent(R"({"order":"run","recipe":"abort)" + std::string(20'000, 'x') + "\"}"));
}

TEST(OrderLine, a_text_with_a_nul_byte_is_refused) {
  for (const char* wrong :
       {R"({"order":"run","recipe":"/jobs/a.yaml\u0000.txt"})", R"({"order":"run","recipe":"a","out":"\u0000"})",
        R"({"order":"run","recipe":"a","under":"x\u0000"})", R"({"order":"run","recipe":"a","serial":"S\u00001"})",
        R"({"order":"run","recipe":"a","certificate":"c\u0000"})", R"({"order":"part_removed","serial":"S\u0000"})",
        R"({"order":"run","recipe":"a","only":["d\u0000"]})", R"({"order":"run","recipe":"a","from":"d\u0000"})",
        R"({"order":"home","only":["C\u0000"]})", R"({"order":"jog","by":{"X\u0000":"1 mm"}})",
        R"({"order":"jog","by":{"X":"1 mm\u0000"}})"}) {
    const auto refused = parse_order(wrong);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_EQ(refused.error().fault, Fault::Refused);
    EXPECT_NE(refused.error().message.find("NUL"), std::string::npos) << refused.error().message;
  }
}

TEST(OrderLine, an_abort_of_ones_own_orders_says_so_clearly_and_any_other_stops_everything) {
  const std::string line = to_line({.kind = OrderKind::Abort, .mine = true});
  EXPECT_EQ(line, R"({"order":"abort","mine":true})");
  EXPECT_TRUE(parse_order(line)->mine);
  EXPECT_TRUE(is_urgent(line));
  for (const char* all : {R"({"order":"abort"})", R"({"order":"abort","mine":false})",
                          R"({"order":"abort","mine":"true"})", R"({"order":"abort","mine":1})"})
    EXPECT_FALSE(parse_order(all)->mine) << all;
  EXPECT_FALSE(parse_order(R"({"order":"home","mine":true})"));
  const std::string hold = to_line({.kind = OrderKind::Hold, .now = true, .mine = true});
  EXPECT_EQ(hold, R"({"order":"hold","now":true,"mine":true})");
  EXPECT_TRUE(parse_order(hold)->mine);
  EXPECT_FALSE(parse_order(R"({"order":"hold","mine":"true"})")->mine);
}

TEST(OrderLine, home_names_the_axes_that_it_homes_alone) {
  const std::string line = to_line({.kind = OrderKind::Home, .axes = {"C", "U"}});
  EXPECT_EQ(line, R"({"order":"home","only":["C","U"]})");
  const auto read = parse_order(line);
  ASSERT_TRUE(read) << to_text(read.error());
  EXPECT_EQ(read->axes, (std::vector<std::string>{"C", "U"}));
  EXPECT_TRUE(parse_order(R"({"order":"home"})")->axes.empty());
  for (const char* wrong : {R"({"order":"home","only":"C"})", R"({"order":"home","only":[]})",
                            R"({"order":"home","only":[1]})", R"({"order":"jog","by":{"X":"1 mm"},"only":["X"]})"}) {
    const auto refused = parse_order(wrong);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_NE(refused.error().message.find("only"), std::string::npos) << wrong;
  }
}

TEST(OrderLine, a_run_names_the_certificate_that_it_demands_and_an_empty_name_is_not_taken_for_none) {
  const run::Order order{.kind = OrderKind::Run, .recipe = "r.yaml", .certificate = "/out/certificate.json"};
  const std::string line = to_line(order);
  EXPECT_EQ(line, R"({"order":"run","recipe":"r.yaml","certificate":"/out/certificate.json"})");
  const auto read = parse_order(line);
  ASSERT_TRUE(read) << to_text(read.error());
  EXPECT_EQ(read->certificate, order.certificate);
  for (const char* wrong :
       {R"({"order":"run","recipe":"r.yaml","certificate":""})", R"({"order":"run","recipe":"r.yaml","certificate":7})",
        R"({"order":"home","certificate":"c.json"})"}) {
    const auto refused = parse_order(wrong);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_NE(refused.error().message.find("certificate"), std::string::npos) << refused.error().message;
  }
}

TEST(OrderLine, a_run_names_the_features_that_it_dispenses_and_a_slip_is_not_taken_for_all) {
  const run::Order order{
      .kind = OrderKind::Run, .recipe = "r.yaml", .serial = "S", .select = {.only = {"dam", "dots[0][3]"}}};
  const std::string line = to_line(order);
  EXPECT_EQ(line, R"({"order":"run","recipe":"r.yaml","serial":"S","only":["dam","dots[0][3]"]})");
  const auto read = parse_order(line);
  ASSERT_TRUE(read) << to_text(read.error());
  EXPECT_EQ(read->select.only, order.select.only);
  EXPECT_TRUE(read->select.from.empty());
  const auto from = parse_order(to_line({.kind = OrderKind::Run, .recipe = "r.yaml", .select = {.from = "dam"}}));
  ASSERT_TRUE(from);
  EXPECT_EQ(from->select.from, "dam");
  EXPECT_TRUE(parse_order(R"({"order":"run","recipe":"r.yaml"})")->select.all());
  for (const char* wrong : {R"("only":"dam")", R"("only":[])", R"("only":["dam",3])", R"("only":null)",
                            R"("from":["dam"])", R"("from":"")", R"("from":1)", R"("from":null)"}) {
    const auto refused = parse_order(std::string(R"({"order":"run","recipe":"r.yaml",)") + wrong + "}");
    ASSERT_FALSE(refused) << wrong;
    EXPECT_NE(refused.error().message.find("for example"), std::string::npos) << wrong;
  }
}

}  // namespace
}  // namespace gantry::desk
