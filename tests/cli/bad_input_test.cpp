// SPDX-License-Identifier: Apache-2.0
// Malformed scenes and files: the exact message, exit code 1, little time and memory. tests/bad
// holds a scene NAME.pbrt and what brume prints for it, NAME.expected; scenes named strict_* are
// checked with --strict. Larger ones are made here.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <regex>
#include <thread>

#include "core/io/image.h"
#include "core/rng.h"
#include "support/folders.h"
#include "support/run_program.h"
#include "support/sanitizers.h"

namespace brume::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const std::filesystem::path kFolder = test::sourceFolder() / "tests/bad";

/// Exit code 1 within 2 s of processor time and 1 GiB.
void expectCheapRefusal(const ProgramResult& result) {
  EXPECT_EQ(result.exitCode, 1);
#if !BRUME_ASAN && !BRUME_TSAN  // these cost several times both
  EXPECT_LT(result.cpuSeconds, 2);
  EXPECT_LT(result.peakBytes, std::size_t{1} << 30);
#endif
}

std::vector<std::string> badScenes() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder))
    if (entry.path().extension() == ".pbrt") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// The lists of choices grow with the plugins and are left out of the comparison.
std::string withoutChoices(const std::string& text) {
  static const std::regex list("; choose .*");
  return std::regex_replace(text, list, "; choose ...");
}

TEST(BadInput, ThereAreAtLeastSixtyScenes) { EXPECT_GE(badScenes().size(), 60u); }

class BadScene : public testing::TestWithParam<std::string> {};

TEST_P(BadScene, IsRefusedWithTheExpectedMessage) {
  const std::string& name = GetParam();
  ProgramInput input;
  input.arguments = {"--check", name + ".pbrt"};
  if (name.starts_with("strict_")) input.arguments.insert(input.arguments.begin(), "--strict");
  input.workingFolder = kFolder;
  const ProgramResult result = runBrume(input);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(withoutChoices(result.err), withoutChoices(readFile(kFolder / (name + ".expected"))));
  EXPECT_THAT(result.err, testing::AnyOf(HasSubstr(".pbrt:"), HasSubstr(".spd")));
  expectCheapRefusal(result);
}

INSTANTIATE_TEST_SUITE_P(Folder, BadScene, testing::ValuesIn(badScenes()),
                         [](const auto& scene) { return scene.param; });

/// Checks a scene text and returns the first line that brume prints.
std::string refusalOf(const TemporaryFolder& folder, const std::string& text) {
  ProgramInput input;
  folder.write("bad.pbrt", text);
  input.arguments = {"--check", "bad.pbrt"};
  input.workingFolder = folder.path();
  const ProgramResult result = runBrume(input);
  expectCheapRefusal(result);
  EXPECT_LT(result.err.size(), 2000u) << "messages stay short whatever the input";
  return result.err.substr(0, result.err.find('\n'));
}

constexpr std::size_t kTenMegabytes = 10'000'000;

TEST(BadInput, TenMegabytesOfOneToken) {
  const TemporaryFolder folder;
  const std::string forty(40, 'x');
  EXPECT_EQ(refusalOf(folder, std::string(kTenMegabytes, 'x')),
            "bad.pbrt:1:1: error: there is no directive '" + forty + "...'");
  EXPECT_THAT(
      refusalOf(folder, "WorldBegin Shape \"" + std::string(kTenMegabytes, 'x') + "\""),
      StartsWith("bad.pbrt:1:18: error: unknown Shape \"" + forty + "...\"; choose 'cone', "));
  EXPECT_EQ(refusalOf(folder, "Translate " + std::string(kTenMegabytes, '9') + " 0 0"),
            "bad.pbrt:1:11: error: '" + std::string(40, '9') + "...' is too large");
  EXPECT_EQ(refusalOf(folder, "WorldBegin Shape \"sphere\" \"float radius\" " +
                                  std::string(kTenMegabytes, '[')),
            "bad.pbrt:1:27: error: the list of \"float radius\" is not closed: ']' is missing "
            "before '['");
  EXPECT_EQ(refusalOf(folder, "WorldBegin Shape \"sphere\" \"float radius\" [" +
                                  std::string(kTenMegabytes, '\n')),
            "bad.pbrt:1:27: error: the list of \"float radius\" is not closed: ']' is missing "
            "before the end of the file");
}

TEST(BadInput, MessagesStayShortWhateverTheyQuote) {
  const TemporaryFolder folder;
  const std::string huge(kTenMegabytes, 'x');
  EXPECT_THAT(refusalOf(folder, "WorldBegin Shape \"sphere\" \"integer " + huge + "\" 1.5"),
              HasSubstr("1.5 is no integer"));
  EXPECT_THAT(refusalOf(folder, "WorldBegin Shape \"sphere\" \"float " + huge + "\" [1 2 \"3\"]"),
              HasSubstr("...\" takes numbers, not the string '3'"));
  EXPECT_THAT(
      refusalOf(folder,
                "WorldBegin Texture \"t\" \"color\" \"imagemap\" \"string wrap\" \"" + huge + "\""),
      HasSubstr("parameter \"string wrap\" of 'imagemap' is 'xxxx"));
  EXPECT_THAT(refusalOf(folder, "Include \"" + huge + "\""), HasSubstr("cannot read 'xxxx"));
}

TEST(BadInput, APipeIsReadOnce) {
  const TemporaryFolder folder;
  const std::string pipe = (folder.path() / "pipe").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] { std::ofstream(pipe) << "Shap"; });
  const ProgramResult result = runBrume({{"--check", pipe}});
  writer.join();
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_THAT(result.err, HasSubstr("pipe:1:1: error: there is no directive 'Shap'"));
}

TEST(BadInput, BinaryNoise) {
  const TemporaryFolder folder;
  Rng rng(42);
  for (int i = 0; i < 8; ++i) {
    std::string noise(4096, '\0');
    for (char& c : noise) c = static_cast<char>(rng.bits32());
    EXPECT_THAT(refusalOf(folder, noise), StartsWith("bad.pbrt:1:"));
  }
}

TEST(BadInput, BlocksOpenedAMillionTimes) {
  const TemporaryFolder folder;
  std::string text = "WorldBegin\n";
  for (int i = 0; i < 1'000'000; ++i) text += "AttributeBegin\n";
  EXPECT_EQ(refusalOf(folder, text),
            "bad.pbrt:10002:1: error: more than 10000 blocks are open here");
}

TEST(BadInput, WarningsAndParametersWithoutEnd) {
  const TemporaryFolder folder;
  std::string text = "WorldBegin\n";
  for (int i = 0; i < 100'000; ++i) text += "Shape \"sphere\" \"float radios\" 2\n";
  folder.write("bad.pbrt", text + "WorldEnd\n");
  const ProgramResult result =
      runBrume({.arguments = {"--check", "bad.pbrt"}, .workingFolder = folder.path()});
  EXPECT_EQ(result.exitCode, 0);
  EXPECT_LT(std::count(result.err.begin(), result.err.end(), '\n'), 310);
  EXPECT_THAT(result.err, HasSubstr("the others are not shown"));

  text = "WorldBegin Shape \"sphere\"\n";
  for (int i = 0; i < 100'000; ++i) text += "\"float p" + std::to_string(i) + "\" 1\n";
  EXPECT_THAT(refusalOf(folder, text), HasSubstr("more than 1000 parameters in one list"));
}

TEST(BadInput, TexturesOfTexturesOfTextures) {
  const TemporaryFolder folder;
  std::string text = "WorldBegin\nTexture \"t0\" \"float\" \"constant\"\n";
  for (int i = 1; i < 10'000; ++i)
    text += "Texture \"t" + std::to_string(i) + "\" \"float\" \"scale\" \"texture tex1\" \"t" +
            std::to_string(i - 1) + "\"\n";
  EXPECT_EQ(refusalOf(folder, text),
            "bad.pbrt:102:24: error: this texture looks up more than 4096 others, or others nested "
            "more than 100 deep");
}

TEST(BadInput, IncludesThatMultiply) {
  // Thirty levels of ten Includes each would be 10^30 files.
  const TemporaryFolder folder;
  for (int i = 0; i < 30; ++i) {
    std::string text;
    for (int j = 0; j < 10; ++j) text += "Include \"" + std::to_string(i + 1) + "\"\n";
    folder.write(std::to_string(i), text);
  }
  folder.write("30", "# the end\n");
  EXPECT_THAT(refusalOf(folder, "Include \"0\""), HasSubstr("there are more than 100000 Includes"));
}

TEST(BadInput, TruncatedImages) {
  const TemporaryFolder folder;
  LayeredImage image;
  image.displaySize = {32, 32};
  image.dataWindow = {{0, 0}, {32, 32}};
  for (const char* channel : {"R", "G", "B"}) image.channels[channel].assign(32 * 32, 0.5f);
  for (const char* extension : {".exr", ".tga", ".png", ".pfm"}) {
    const std::string name = std::string("whole") + extension;
    writeImage((folder.path() / name).string(), image);
    const std::string bytes = readFile(folder.path() / name);
    for (const std::size_t kept : {std::size_t{0}, std::size_t{10}, bytes.size() / 2}) {
      folder.write(std::string("cut") + extension, bytes.substr(0, kept));
      EXPECT_THAT(refusalOf(folder,
                            "WorldBegin\nTexture \"t\" \"color\" \"imagemap\"\n"
                            "  \"string filename\" \"cut" +
                                std::string(extension) +
                                "\"\nMaterial \"matte\" \"texture Kd\" \"t\"\n"
                                "Shape \"sphere\"\nWorldEnd\n"),
                  StartsWith("bad.pbrt:3:3: error: "))
          << extension << " cut to " << kept;
    }
  }
}

TEST(BadInput, TruncatedBrdf) {
  const TemporaryFolder folder;
  const auto refuse = [&](const std::string& name, const std::string& bytes) {
    folder.write(name, bytes);
    return refusalOf(folder, "WorldBegin\nMaterial \"measured\" \"string filename\" \"" + name +
                                 "\"\nShape \"sphere\"\nWorldEnd\n");
  };
  EXPECT_THAT(refuse("cut.binary", std::string("\x5a\0\0\0\x5a\0\0\0\xb4\0\0\0half", 16)),
              StartsWith("bad.pbrt:2:21: error: "));
  EXPECT_THAT(refuse("empty.binary", ""), StartsWith("bad.pbrt:2:21: error: "));
  EXPECT_THAT(refuse("cut.brdf", "3 400 500 600 0.1 0.2"), HasSubstr("error: "));
  EXPECT_THAT(refuse("empty.brdf", ""), HasSubstr("error: "));
}

TEST(BadInput, FilesThatAreNoScenes) {
  const auto errorOf = [](ProgramInput input) {
    const ProgramResult result = runBrume(input);
    expectCheapRefusal(result);
    return result.err;
  };
  EXPECT_THAT(errorOf({{"--check", "nowhere.pbrt"}}),
              StartsWith("brume: error: cannot read 'nowhere.pbrt': No such file"));
  EXPECT_THAT(errorOf({{"--check", "/"}}), HasSubstr("cannot read '/': it is a directory"));
  EXPECT_THAT(errorOf({{"--check", "-"}}), HasSubstr("<stdin>:1:1: error: the file ends without"));
  EXPECT_THAT(errorOf({{"--check", "/dev/zero"}}),
              HasSubstr("cannot read '/dev/zero': it is no regular file"));
}

}  // namespace
}  // namespace brume::test
