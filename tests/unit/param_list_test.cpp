// SPDX-License-Identifier: Apache-2.0
#include "core/parse/param_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "core/spectrum.h"

namespace brume {
namespace {

using testing::ElementsAre;

/// The parameter list of a text and what came of it.
struct List {
  ParamSet set;
  std::vector<std::string> warnings;
  std::string error;

  template <class T>
  std::vector<T> values(ParamType type, const char* name) {
    Param* p = set.find(type, name);
    return p ? std::get<std::vector<T>>(p->values) : std::vector<T>{};
  }
};

List read(std::string_view text, const std::string& directory = "") {
  Log log({Verbosity::Normal, false, true});
  List list;
  TokenStream tokens(SourceFile(InputFile::borrow(text), internFileName("t")), directory);
  ParamListReader reader(tokens, log);
  try {
    list.set = reader.read({});
    EXPECT_EQ(tokens.next().kind, Token::Kind::End);
  } catch (const SceneError& e) {
    list.error = toString(e.where()) + ": " + e.what();
  }
  list.warnings = log.captured();
  return list;
}

TEST(ParamList, DecodesEveryType) {
  List list = read(
      "\"float f\" [1 2.5] \"integer i\" 3 \"bool b\" [\"true\" \"false\"] \"point P\" [1 2 3 4 5 "
      "6]"
      "\"vector v\" [1 0 0] \"normal N\" [0 0 1] \"string s\" \"a b\" \"texture t\" \"tex\""
      "\"color c\" [1 2 3] \"rgb r\" [4 5 6] \"xyz x\" [1 1 1]");
  EXPECT_EQ(list.error, "");
  EXPECT_THAT(list.values<float>(ParamType::Float, "f"), ElementsAre(1.f, 2.5f));
  EXPECT_THAT(list.values<int>(ParamType::Integer, "i"), ElementsAre(3));
  EXPECT_THAT(list.values<bool>(ParamType::Bool, "b"), ElementsAre(true, false));
  EXPECT_THAT(list.values<Vec3>(ParamType::Point, "P"), ElementsAre(Vec3(1, 2, 3), Vec3(4, 5, 6)));
  EXPECT_THAT(list.values<Vec3>(ParamType::Vector, "v"), ElementsAre(Vec3(1, 0, 0)));
  EXPECT_THAT(list.values<Vec3>(ParamType::Normal, "N"), ElementsAre(Vec3(0, 0, 1)));
  EXPECT_THAT(list.values<std::string>(ParamType::String, "s"), ElementsAre("a b"));
  EXPECT_THAT(list.values<std::string>(ParamType::Texture, "t"), ElementsAre("tex"));
  EXPECT_THAT(list.values<Rgb>(ParamType::Color, "c"), ElementsAre(Rgb(1, 2, 3)));
  EXPECT_THAT(list.values<Rgb>(ParamType::Color, "r"), ElementsAre(Rgb(4, 5, 6)));
  EXPECT_THAT(list.values<Rgb>(ParamType::Color, "x"), ElementsAre(rgbFromXyz(1, 1, 1)));
}

TEST(ParamList, ConvertsSpectra) {
  List list = read("\"spectrum s\" [600 1 400 2] \"blackbody b\" [3000 2 5000 1]");
  const std::vector<float> lambda{400, 600}, value{2, 1};
  EXPECT_THAT(list.values<Rgb>(ParamType::Color, "s"), ElementsAre(rgbFromSamples(lambda, value)));
  EXPECT_THAT(list.values<Rgb>(ParamType::Color, "b"),
              ElementsAre(rgbFromBlackbody(3000) * 2.f, rgbFromBlackbody(5000)));
}

TEST(ParamList, IntegersAreExact) {
  List list = read("\"integer i\" [2147483647 -2147483648 16777217 4.0 1e3]");
  EXPECT_THAT(list.values<int>(ParamType::Integer, "i"),
              ElementsAre(2147483647, -2147483647 - 1, 16777217, 4, 1000));
  EXPECT_EQ(read("\"integer i\" [1 1.5]").error, "t:1:16: '1.5' is no integer");
  EXPECT_EQ(read("\"integer i\" 2147483648").error,
            "t:1:13: 2147483648 is too large for an integer");
}

TEST(ParamList, TheLaterOfTwoCounts) {
  List list = read("\"float f\" 1 \"float f\" 2 \"color f\" [1 1 1]");
  EXPECT_THAT(list.values<float>(ParamType::Float, "f"), ElementsAre(2.f));
  EXPECT_THAT(list.values<Rgb>(ParamType::Color, "f"), ElementsAre(Rgb(1)));
  ASSERT_EQ(list.warnings.size(), 1u);
  EXPECT_THAT(list.warnings[0], testing::HasSubstr("given twice"));
}

TEST(ParamList, ReservesExactly) {
  std::string text = "\"float f\" [";
  for (int i = 0; i < 1000; ++i) text += " 0.25";
  List list = read(text + "]");
  const auto& values = std::get<std::vector<float>>(list.set.find(ParamType::Float, "f")->values);
  EXPECT_EQ(values.size(), 1000u);
  EXPECT_LE(values.capacity(), 1001u);
}

struct Bad {
  const char* text;
  const char* error;
};

TEST(ParamList, SaysWhatIsWrong) {
  const Bad cases[] = {
      {"\"flot f\" 1",
       "t:1:1: 'flot f' does not begin with a parameter type: 'float', 'integer', 'bool', 'point', "
       "'vector', 'normal', 'string', 'texture', 'color', 'rgb', 'xyz', 'blackbody' or 'spectrum' "
       "(did you mean 'float'?)"},
      {"\"float\" 1", "t:1:1: the parameter 'float' has a type but no name"},
      {"\"float a b\" 1", "t:1:1: 'float a b' must be a type and a name"},
      {"\"float f\"", "t:1:1: \"float f\" needs a value, but the end of the file follows"},
      {"\"float f\" []", "t:1:1: \"float f\" needs at least one value"},
      {"\"string f\" []", "t:1:1: \"string f\" needs at least one value"},
      {"\"float f\" \"1\"", "t:1:11: \"float f\" takes numbers, not the string '1'"},
      {"\"float f\" [1 \"2\"]", "t:1:14: \"float f\" takes numbers, not the string '2'"},
      {"\"string s\" 1", "t:1:12: \"string s\" takes strings in quotes, not the number 1"},
      {"\"bool b\" [true]", "t:1:11: \"bool b\" takes \"true\" or \"false\" in quotes, not 'true'"},
      {"\"bool b\" \"yes\"", "t:1:1: \"bool b\" takes \"true\" or \"false\", not 'yes'"},
      {"\"point P\" [1 2 3 4]", "t:1:1: \"point P\" has 4 numbers, but takes them in groups of 3"},
      {"\"color c\" 1", "t:1:1: \"color c\" has 1 numbers, but takes them in groups of 3"},
      {"\"spectrum c\" [400 1 500]",
       "t:1:1: \"spectrum c\" has 3 numbers, but takes them in pairs"},
      {"\"spectrum c\" [-1 1]",
       "t:1:1: \"spectrum c\" has the wavelength -1; it takes pairs of a positive wavelength in nm "
       "and a value"},
      {"\"float f\" [1 2",
       "t:1:1: the list of \"float f\" is not closed: ']' is missing before the end of the file"},
      {"\"float f\" [1 [2",
       "t:1:1: the list of \"float f\" is not closed: ']' is missing before '['"},
      {"\"float f\" [1 nan]", "t:1:14: \"float f\" takes numbers, not 'nan'"},
      {"\"float f\" [1 1e39]", "t:1:14: '1e39' is too large for a float"},
      {"\"float f\" 1e39", "t:1:11: 1e+39 is too large for a float"},
      {"\"texture t\" [\"a\" \"b\"]", "t:1:1: \"texture t\" takes one texture name, not 2"},
  };
  for (const Bad& c : cases) EXPECT_EQ(read(c.text).error, c.error) << c.text;
}

TEST(ParamList, ReadsSpectrumFiles) {
  const std::filesystem::path directory =
      std::filesystem::path(testing::TempDir()) / ("brume_spd_" + std::to_string(::getpid()));
  std::filesystem::create_directory(directory);
  const auto write = [&](const char* name, const char* text) {
    std::ofstream(directory / name) << text;
  };
  write("good.spd", "# silver\n400 1.5 # inline\n 500\t2E0\r\n600 2.5");  // no newline at the end
  write("odd.spd", "400 1 500");
  write("text.spd", "400 1\n500 x");
  write("empty.spd", "# nothing\n");

  const std::vector<float> lambda{400, 500, 600}, value{1.5f, 2, 2.5f};
  List list = read("\"spectrum a\" \"good.spd\" \"spectrum b\" [\"good.spd\" \"good.spd\"]",
                   directory.string());
  const Rgb expected = rgbFromSamples(lambda, value);
  EXPECT_THAT(list.values<Rgb>(ParamType::Color, "a"), ElementsAre(expected));
  EXPECT_THAT(list.values<Rgb>(ParamType::Color, "b"), ElementsAre(expected, expected));

  const auto errorOf = [&](const std::string& name) {
    return read("\"spectrum a\" \"" + name + "\"", directory.string()).error;
  };
  const std::string prefix = directory.string() + "/";
  EXPECT_EQ(errorOf("odd.spd"),
            prefix + "odd.spd: this spectrum has 3 numbers, but takes them in pairs");
  EXPECT_EQ(errorOf("text.spd"), prefix + "text.spd:2:5: 'x' is not a number");
  EXPECT_EQ(errorOf("empty.spd"), "t:1:1: '" + prefix + "empty.spd' holds no numbers");
  EXPECT_EQ(errorOf("none.spd"),
            "t:1:1: cannot read '" + prefix + "none.spd': No such file or directory");
  std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace brume
