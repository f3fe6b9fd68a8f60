// What pages may send.
#include "service/monitor/page/page_requests.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

#include "service/monitor/page/page_messages.h"

namespace omni::monitor {
namespace test_monitor_page_requests {

template <class T>
T As(const std::string& text) {
  const auto request = ReadPageRequest(text);
  EXPECT_TRUE(request.ok()) << (request.ok() ? "" : request.error());
  EXPECT_TRUE(request.ok() && std::holds_alternative<T>(*request)) << text;
  return request.ok() && std::holds_alternative<T>(*request) ? std::get<T>(*request) : T{};
}

TEST(PageRequests, EachKindIsRead) {
  const AimRequest aim = As<AimRequest>(R"({"type":"aim","tip":[0.01,-0.02,0.08],"axis":[0,0,-1]})");
  EXPECT_EQ(aim.tip_base_m, (std::array<double, 3>{0.01, -0.02, 0.08}));
  As<LiftRequest>(R"({"type":"lift"})");
  EXPECT_EQ(As<SceneRequest>(R"({"type":"scene","name":"dragon"})").name, "dragon");
  EXPECT_EQ(As<EditRequest>(R"({"type":"undo"})").action, protocol::SceneAction::kUndo);
  EXPECT_EQ(As<EditRequest>(R"({"type":"redo"})").action, protocol::SceneAction::kRedo);
  EXPECT_EQ(As<EditRequest>(R"({"type":"release"})").action, protocol::SceneAction::kRelease);
  EXPECT_EQ(As<SaveRequest>(R"({"type":"save","number":7})").number, 7U);
  EXPECT_FALSE(As<StopRequest>(R"({"type":"stop","on":false})").on);
  const MaterialRequest material =
      As<MaterialRequest>(R"({"type":"material","index":2,"values":{"stiffness":300,"popThrough":1}})");
  EXPECT_EQ(material.index, 2U);
  EXPECT_EQ(material.values.stiffness_N_m, 300);
  EXPECT_EQ(material.values.pop_through_N, 1);
  EXPECT_EQ(std::count(material.given.begin(), material.given.end(), true), 2);
}

TEST(PageRequests, WrongOnesAreRefusedWithTheField) {
  struct Case {
    const char* text;
    const char* names;
  };
  for (const Case& wrong : {
           Case{"", "request"},
           Case{"[]", "no object"},
           Case{"{}", "type"},
           Case{R"({"type":"fire"})", "type"},
           Case{R"({"type":"aim","tip":[0,0],"axis":[0,0,-1]})", "tip"},
           Case{R"({"type":"aim","tip":[0,0,"x"],"axis":[0,0,-1]})", "tip"},
           Case{R"({"type":"aim","tip":[0,0,1e9],"axis":[0,0,-1]})", "1 m"},
           Case{R"({"type":"aim","tip":[0,0,0],"axis":[0,0,0]})", "unit"},
           Case{R"({"type":"scene","name":7})", "name"},
           Case{R"({"type":"save","number":-1})", "number"},
           Case{R"({"type":"save","number":1.5})", "number"},
           Case{R"({"type":"stop","on":1})", "on"},
           Case{R"({"type":"material","index":0,"values":{"stiffness":1e9}})", "values/stiffness"},
           Case{R"({"type":"material","index":0,"values":{"magnet.range":0.001}})", "values/magnet.range"},
           Case{R"({"type":"material","index":0,"values":[1]})", "values"},
       }) {
    const auto request = ReadPageRequest(wrong.text);
    ASSERT_FALSE(request.ok()) << wrong.text;
    EXPECT_NE(request.error().find(wrong.names), std::string::npos) << request.error();
  }
  EXPECT_FALSE(ReadPageRequest(std::string(kMaxRequestBytes + 1, ' ')).ok());
  EXPECT_FALSE(ReadPageRequest(std::string(1000, '[')).ok());
}

// Damaged requests: read or refused, and what is read is in range. OMNI_FUZZ: how many.
TEST(PageRequestsRandom, DamagedTextIsRefusedOrInRange) {
  const char* wanted = std::getenv("OMNI_FUZZ");
  const long rounds = wanted == nullptr ? 20'000 : std::atol(wanted);
  const std::string seeds[] = {R"({"type":"aim","tip":[0.01,-0.02,0.08],"axis":[0,0,-1]})",
                               R"({"type":"material","index":2,"values":{"stiffness":300,"vibration.frequency":90}})",
                               R"({"type":"scene","name":"dragon"})", R"({"type":"save","number":7})"};
  std::mt19937_64 random(2401);
  long read = 0;
  for (long i = 0; i < rounds; ++i) {
    std::string text = seeds[random() % std::size(seeds)];
    for (std::uint64_t n = random() % 4; n > 0; --n) {
      const std::size_t at = random() % text.size();
      if (random() % 2 == 0) text[at] = static_cast<char>(random());
      if (random() % 4 == 0) text.insert(at, 1, "0123456789eE+-.,:[]{}\"n"[random() % 23]);
      if (random() % 4 == 0 && text.size() > 1) text.erase(at, 1);
    }
    const auto request = ReadPageRequest(text);
    if (!request.ok()) continue;
    ++read;
    if (const auto* aim = std::get_if<AimRequest>(&*request)) {
      for (const double x : aim->tip_base_m) EXPECT_LE(std::abs(x), 1);
    }
    if (const auto* material = std::get_if<MaterialRequest>(&*request)) {
      for (std::size_t k = 0; k < base::kLiveFields.size(); ++k) {
        const base::MaterialField& field = *base::kLiveFields[k];
        EXPECT_TRUE(!material->given[k] || field.Contains(material->values.*field.live));
      }
    }
  }
  RecordProperty("read", std::to_string(read));
  EXPECT_GT(read, rounds / 20);
}

std::string DropMessage(const std::string& name, const std::string& bytes) {
  std::string message("OMPG\x10\x00\x01\x00", 8);
  const auto size = static_cast<std::uint32_t>(name.size());
  message.append(reinterpret_cast<const char*>(&size), 4);
  return message + name + bytes;
}

TEST(DroppedFiles, GlbIsTakenAndOthersAreNamed) {
  const std::string glb = "glTF" + std::string(20, '\0');
  const std::string message = DropMessage("a b.glb", glb);
  const DroppedFile file = ReadDroppedFile(message);
  EXPECT_EQ(file.problem, "");
  EXPECT_EQ(file.name, "a b.glb");
  EXPECT_EQ(file.bytes, glb);
  EXPECT_NE(ReadDroppedFile(DropMessage("a.png", "\x89PNG" + std::string(20, '\0'))).problem.find(".glb"),
            std::string::npos);
  for (std::size_t i = 0; i < 12; ++i) EXPECT_FALSE(ReadDroppedFile(message.substr(0, i)).problem.empty()) << i;
  std::string long_name = message;
  long_name[8] = '\xff';
  long_name[9] = '\xff';
  EXPECT_FALSE(ReadDroppedFile(long_name).problem.empty());
}

}  // namespace test_monitor_page_requests
}  // namespace omni::monitor
