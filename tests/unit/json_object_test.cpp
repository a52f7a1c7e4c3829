// SPDX-License-Identifier: Apache-2.0
#include "tools/json_object.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "core/error.h"

namespace brume {
namespace {

std::string errorOf(const std::function<void()>& f) {
  try {
    f();
  } catch (const SceneError& error) {
    return error.what();
  }
  return "no error";
}

const Json kFile = Json::parse(R"({"number": 2.5, "whole": 3, "word": "fog", "list": ["a", "b"],
  "flag": true, "inner": {"seeds": [1, 2], "oops": 1}, "many": [{"x": 1}, {"y": 2}]})");

TEST(JsonObject, ReadsEveryType) {
  JsonObject object(kFile, "file.json");
  EXPECT_EQ(object.number("number", 0, 3), 2.5);
  EXPECT_EQ(object.number("whole", 0, 3), 3);
  EXPECT_EQ(object.whole("whole", 0, 3), 3);
  EXPECT_EQ(object.string("word"), "fog");
  EXPECT_EQ(object.strings("list"), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(object.strings("word"), std::vector<std::string>{"fog"});
  EXPECT_EQ(object.boolean("flag"), true);
  EXPECT_EQ(object.object("inner")->wholes("seeds", 0, 9), (std::vector<std::int64_t>{1, 2}));
  EXPECT_EQ(object.objects("many").size(), 2u);
  object.finish();
  EXPECT_FALSE(object.number("absent", 0, 1));
  EXPECT_TRUE(object.strings("absent").empty());
}

TEST(JsonObject, SaysWhatIsWrong) {
  JsonObject object(kFile, "file.json");
  EXPECT_EQ(errorOf([&] { object.number("word", 0, 1); }),
            "file.json: word must be a number from 0 to 1");
  EXPECT_EQ(errorOf([&] { object.whole("number", 0, 9); }),
            "file.json: number must be a whole number from 0 to 9");
  EXPECT_EQ(errorOf([&] { object.whole("whole", 4, 9); }),
            "file.json: whole must be a whole number from 4 to 9");
  EXPECT_EQ(errorOf([&] { object.string("flag"); }), "file.json: flag must be a string");
  EXPECT_EQ(errorOf([&] { object.strings("flag"); }),
            "file.json: flag must be a string or a list of strings");
  EXPECT_EQ(errorOf([&] { object.object("word"); }), "file.json: word must be an object {...}");
  JsonObject inner = *object.object("inner");
  EXPECT_EQ(errorOf([&] { inner.wholes("seeds", 0, 1); }),
            "file.json: inner.seeds must be a whole number from 0 to 1, or a list of such");
  inner.any("opps");
  EXPECT_EQ(errorOf([&] { inner.finish(); }),
            "file.json: inner: unknown key \"oops\" (did you mean 'opps'?); the keys are 'seeds' "
            "or 'opps'");
}

TEST(JsonObject, SyntaxErrorsHaveTheirPlace) {
  const std::string path =
      (std::filesystem::temp_directory_path() / ("brume_json_" + std::to_string(getpid())))
          .string();
  std::ofstream(path) << "{ // a comment\n  \"a\": 1,\n  \"b\" 2\n}\n";
  const std::string error = errorOf([&] { readJsonFile(path); });
  std::ofstream(path) << "{ // a comment\n  \"a\": 1}\n";
  const Json json = readJsonFile(path);
  std::filesystem::remove(path);
  EXPECT_TRUE(error.starts_with(path + ":3:7: this is not JSON: syntax error")) << error;
  EXPECT_EQ(json["a"], 1);
}

}  // namespace
}  // namespace brume
