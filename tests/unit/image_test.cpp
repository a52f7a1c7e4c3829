// SPDX-License-Identifier: Apache-2.0
#include "core/io/image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>

#include "core/io/exr_file.h"
#include "core/io/file_bytes.h"
#include "core/io/image_head.h"
#include "core/io/pfm_file.h"
#include "core/io/stb_image_file.h"
#include "core/srgb.h"

namespace brume {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class ImageFile : public ::testing::Test {
 protected:
  void SetUp() override {
    directory_ = fs::temp_directory_path() /
                 ("brume-image-" + std::to_string(::getpid()) + "-" +
                  ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(directory_);
  }
  void TearDown() override {
    fs::permissions(directory_, fs::perms::owner_all);
    fs::remove_all(directory_);
  }
  std::string path(const std::string& name) const { return (directory_ / name).string(); }
  void writeBytes(const std::string& name, const Bytes& bytes) const {
    std::ofstream out(path(name), std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
  }
  std::size_t fileCount() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(directory_), fs::directory_iterator()));
  }
  fs::path directory_;
};

/// Every value differs, some are outside [0, 1].
RgbImage ramp(int width, int height) {
  RgbImage image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.at(x, y) = {0.1f * static_cast<float>(x), 0.3f * static_cast<float>(y) - 0.1f,
                        1.f / static_cast<float>(1 + x + y * width)};
  return image;
}

void append(Bytes& bytes, std::initializer_list<int> values) {
  for (const int value : values) bytes.push_back(static_cast<unsigned char>(value));
}

std::string errorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const SceneError& e) {
    return e.what();
  }
  return "no error";
}

Bytes fileBytes(const std::string& path) { return readFileBytes(path, 1 << 20); }

TEST_F(ImageFile, ExrKeepsFloatsWindowsChannelsAndMetadata) {
  LayeredImage image;
  image.displaySize = {10, 8};
  image.dataWindow = {{3, 2}, {6, 4}};
  image.metadata = {{"brume:seed", "7"}, {"owner", "a \"quoted\"\nline"}};
  for (const char* name : {"R", "G", "B", "variance.R", "depth.Z"}) {
    std::vector<float>& values = image.channels[name];
    for (int i = 0; i < 6; ++i)
      values.push_back(static_cast<float>(name[0]) + 1.f / static_cast<float>(i + 3));
  }
  image.channels["R"][0] = kInfinity;
  image.channels["R"][1] = std::nanf("");
  image.channels["R"][2] = 1e-42f;  // subnormal
  writeImage(path("a.exr"), image);
  const LayeredImage back = readLayeredImage(path("a.exr"));
  EXPECT_EQ(back.displaySize, image.displaySize);
  EXPECT_EQ(back.dataWindow.lo, image.dataWindow.lo);
  EXPECT_EQ(back.dataWindow.hi, image.dataWindow.hi);
  EXPECT_EQ(back.metadata, image.metadata);
  ASSERT_EQ(back.channels.size(), image.channels.size());
  for (const auto& [name, values] : image.channels)
    for (std::size_t i = 0; i < values.size(); ++i)
      EXPECT_EQ(std::bit_cast<std::uint32_t>(back.channels.at(name)[i]),
                std::bit_cast<std::uint32_t>(values[i]))
          << name << i;
}

TEST_F(ImageFile, ExrHalfRoundsToNearestEvenAndSaturates) {
  RgbImage image(4, 1);
  image.pixels = {Rgb(1.f + 0x1p-11f, 1.f + 3 * 0x1p-11f, 1.f + 0x1.01p-11f),
                  Rgb(1e6f, -1e6f, 65519.f), Rgb(kInfinity, -kInfinity, std::nanf("")),
                  Rgb(0x1p-24f, 0x1p-25f, 0x1.8p-25f)};
  writeImage(path("half.exr"), image, PixelPrecision::Half);
  const RgbImage back = readImage(path("half.exr"));
  EXPECT_EQ(back.pixels[0], Rgb(1.f, 1.f + 2 * 0x1p-10f, 1.f + 0x1p-10f));
  EXPECT_EQ(back.pixels[1], Rgb(65504.f, -65504.f, 65504.f));
  EXPECT_EQ(back.pixels[2].r, kInfinity);
  EXPECT_EQ(back.pixels[2].g, -kInfinity);
  EXPECT_TRUE(std::isnan(back.pixels[2].b));
  EXPECT_EQ(back.pixels[3], Rgb(0x1p-24f, 0.f, 0x1p-24f));
}

TEST_F(ImageFile, LoneLuminanceFillsAllChannels) {
  LayeredImage image;
  image.displaySize = {2, 1};
  image.dataWindow = {{0, 0}, {2, 1}};
  image.channels["Y"] = {.25f, 3.f};
  writeImage(path("y.exr"), image);
  EXPECT_EQ(readImage(path("y.exr")).pixels[1], Rgb(3.f));
  image.channels = {{"Z", {1.f, 2.f}}};
  writeImage(path("z.exr"), image);
  EXPECT_THAT(errorOf([&] { readImage(path("z.exr")); }),
              HasSubstr("neither channels R, G, B nor Y"));
}

TEST_F(ImageFile, PfmIsExactInBothEndiansAndBottomUp) {
  const RgbImage image = ramp(5, 3);
  writeImage(path("a.pfm"), image);
  EXPECT_EQ(readImage(path("a.pfm")).pixels, image.pixels);

  // One channel, big endian, scale 2: the first row of the file is the lowest.
  const std::string header = "Pf\n1 2\n2.0\n";
  Bytes bytes(header.begin(), header.end());
  append(bytes, {0x3f, 0x80, 0x00, 0x00, 0x40, 0x40, 0x00, 0x00});
  writeBytes("big.pfm", bytes);
  const RgbImage big = readImage(path("big.pfm"));
  EXPECT_EQ(big.at(0, 1), Rgb(2.f));
  EXPECT_EQ(big.at(0, 0), Rgb(6.f));
}

TEST_F(ImageFile, PngAndTgaKeepChannelOrderAndEncodeSrgb) {
  RgbImage image(3, 2);
  image.pixels = {Rgb(1, 0, 0), Rgb(0, 1, 0),  Rgb(0, 0, 1),
                  Rgb(.5f),     Rgb(2, -1, 0), Rgb(std::nanf(""), kInfinity, .0031308f)};
  for (const char* name : {"a.png", "a.tga"}) {
    writeImage(path(name), image);
    const RgbImage back = readImage(path(name));
    ASSERT_EQ(back.width, 3);
    EXPECT_EQ(back.at(0, 0), Rgb(1, 0, 0));
    EXPECT_EQ(back.at(1, 0), Rgb(0, 1, 0));
    EXPECT_EQ(back.at(2, 0), Rgb(0, 0, 1));
    EXPECT_EQ(back.at(0, 1), Rgb(188 / 255.f));  // sRGB of one half is 187.5
    EXPECT_EQ(back.at(1, 1), Rgb(1, 0, 0));
    EXPECT_EQ(back.at(2, 1), Rgb(0, 1, 10 / 255.f));
  }
}

TEST_F(ImageFile, SrgbCurveIsInvertedByDecode) {
  for (int i = 0; i <= 255; ++i) {
    const float code = static_cast<float>(i) / 255.f;
    EXPECT_EQ(encodeSrgb8(decodeSrgb(code)), i);
  }
}

TEST_F(ImageFile, TextureOrderPutsT0First) {
  const RgbImage image = ramp(2, 3);
  writeImage(path("a.exr"), image);
  writeImage(path("a.pfm"), image);
  EXPECT_EQ(readTextureImage(path("a.exr")).pixels, image.pixels);
  EXPECT_EQ(readTextureImage(path("a.pfm")).at(1, 0), image.at(1, 2));
  EXPECT_EQ(readTextureImage(path("a.pfm")).at(0, 1), image.at(0, 1));
}

/// A valid small HDR file: flat pixels (width below 8) and a run-length coded one.
Bytes hdrBytes(int width, int height, bool coded) {
  const std::string header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(height) +
                             " +X " + std::to_string(width) + "\n";
  Bytes bytes(header.begin(), header.end());
  for (int y = 0; y < height; ++y) {
    if (!coded) {
      for (int x = 0; x < width; ++x) append(bytes, {128, 64, 32, 129});
      continue;
    }
    append(bytes, {2, 2, 0, width});
    for (const int value : {128, 64, 32, 129}) append(bytes, {128 + width, value});
  }
  return bytes;
}

TEST_F(ImageFile, HdrValues) {
  for (const bool coded : {false, true}) {
    writeBytes("a.hdr", hdrBytes(coded ? 9 : 3, 2, coded));
    const RgbImage image = readImage(path("a.hdr"));
    ASSERT_EQ(image.height, 2);
    for (const Rgb& pixel : image.pixels) EXPECT_EQ(pixel, Rgb(1.f, .5f, .25f));
  }
}

/// A 1 x 1 grey baseline JPEG.
Bytes tinyJpeg() {
  Bytes bytes{0xff, 0xd8, 0xff, 0xdb, 0x00, 0x43, 0x00};
  bytes.insert(bytes.end(), 64, 1);
  append(bytes, {0xff, 0xc0, 0x00, 0x0b, 8, 0, 1, 0, 1, 1, 1, 0x11, 0});
  // Huffman tables with one code each: DC size 0, AC end of block.
  for (const int table : {0x00, 0x10}) {
    append(bytes, {0xff, 0xc4, 0x00, 0x14});
    append(bytes, {table, 1});
    bytes.insert(bytes.end(), 15, 0);
    bytes.push_back(0);
  }
  append(bytes, {0xff, 0xda, 0x00, 0x08, 1, 1, 0x00, 0, 63, 0, 0x3f, 0xff, 0xd9});
  return bytes;
}

TEST_F(ImageFile, JpegValue) {
  writeBytes("a.jpg", tinyJpeg());
  EXPECT_EQ(readImage(path("a.jpg")).pixels.at(0),
            Rgb(128 / 255.f));  // zero coefficients: mid grey
}

TEST_F(ImageFile, JpegTablesAreCheckedBeforeDecoding) {
  const Bytes good = tinyJpeg();
  // The first Huffman table follows start, quantisation table and frame: 2 + 69 + 13 bytes.
  constexpr std::size_t kCounts = 2 + 69 + 13 + 5;
  Bytes tooManyCodes = good;
  tooManyCodes[kCounts + 15] = 255;
  tooManyCodes[kCounts + 14] = 255;
  EXPECT_THAT(errorOf([&] { decodeStbImage(tooManyCodes); }), HasSubstr("bad Huffman table"));
  Bytes otherTable = good;
  otherTable[good.size() - 7] = 0x11;  // the scan uses tables 1, only tables 0 exist
  EXPECT_THAT(errorOf([&] { decodeStbImage(otherTable); }), HasSubstr("Huffman table is missing"));
}

/// A run-length coded 24-bit TGA of 3 x 2 pixels, top row first.
Bytes codedTga() {
  return {0,    0, 10, 0, 0, 0,  0,    0,    0,  0,  0,
          0,    3, 0,  2, 0, 24, 0x20, 0x82, 10, 20, 30,  // a run of three
          0x02, 1, 2,  3, 4, 5,  6,    7,    8,  9};      // three literals
}

TEST_F(ImageFile, CodedTgaValues) {
  writeBytes("a.tga", codedTga());
  const RgbImage image = readImage(path("a.tga"));
  EXPECT_EQ(image.at(2, 0), Rgb(30 / 255.f, 20 / 255.f, 10 / 255.f));
  EXPECT_EQ(image.at(1, 1), Rgb(6 / 255.f, 5 / 255.f, 4 / 255.f));
}

std::vector<std::pair<std::string, Bytes>> smallFiles(const std::string& directory) {
  const RgbImage image = ramp(3, 2);
  std::vector<std::pair<std::string, Bytes>> files;
  for (const char* extension : {".exr", ".png", ".tga", ".pfm"}) {
    writeImage(directory + "/small" + extension, image);
    files.emplace_back(extension, fileBytes(directory + "/small" + extension));
  }
  files.emplace_back(".hdr", hdrBytes(3, 2, false));
  files.emplace_back(".hdr", hdrBytes(9, 2, true));
  files.emplace_back(".jpg", tinyJpeg());
  files.emplace_back(".tga", codedTga());
  return files;
}

LayeredImage decodeAny(const std::string& extension, ByteSpan bytes) {
  if (extension == ".exr") return decodeExr(bytes, "test", [](const auto&) { return true; });
  const RgbImage image = extension == ".pfm" ? decodePfm(bytes) : decodeStbImage(bytes);
  LayeredImage layered;
  layered.dataWindow.hi = {image.width, image.height};
  return layered;
}

TEST_F(ImageFile, EveryTruncationIsAnError) {
  for (const auto& [extension, bytes] : smallFiles(directory_.string())) {
    EXPECT_NO_THROW(decodeAny(extension, bytes)) << extension;
    // The TGA encoder adds no footer, so the last byte of every format matters.
    for (std::size_t length = 0; length < bytes.size(); ++length)
      EXPECT_THROW(decodeAny(extension, ByteSpan(bytes).first(length)), SceneError)
          << extension << " cut at " << length << " of " << bytes.size();
  }
}

// --- without decoding ---

TEST_F(ImageFile, HeadAndEndTellTheSizeOfWholeFiles) {
  int i = 0;
  for (const auto& [extension, bytes] : smallFiles(directory_.string())) {
    const std::string name = "copy" + std::to_string(i++) + extension;
    writeBytes(name, bytes);
    const LayeredImage image = decodeAny(extension, bytes);
    EXPECT_EQ(sizeOfWholeImage(path(name)),
              Vec2i(image.dataWindow.width(), image.dataWindow.height()))
        << name;
    // What is cut off is never taken for whole.
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      writeBytes(name, Bytes(bytes.begin(), bytes.begin() + static_cast<long>(length)));
      EXPECT_EQ(sizeOfWholeImage(path(name)), std::nullopt) << name << " cut at " << length;
    }
  }
}

TEST_F(ImageFile, LargeExrFilesAreWholeByTheirTable) {
  for (const PixelPrecision precision : {PixelPrecision::Half, PixelPrecision::Float}) {
    writeImage(path("large.exr"), ramp(61, 203), precision);
    EXPECT_EQ(sizeOfWholeImage(path("large.exr")), Vec2i(61, 203));
    const Bytes bytes = fileBytes(path("large.exr"));
    writeBytes("large.exr", Bytes(bytes.begin(), bytes.end() - 1));
    EXPECT_EQ(sizeOfWholeImage(path("large.exr")), std::nullopt);
  }
}

/// 3 x 2 pixels of one half channel Y in two tiles of 2 x 2, not compressed.
Bytes tiledExr() {
  Bytes bytes;
  const auto u32 = [&](std::uint32_t v) {
    for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<unsigned char>(v >> 8 * i));
  };
  const auto text = [&](const std::string& t) {
    bytes.insert(bytes.end(), t.begin(), t.end());
    bytes.push_back(0);
  };
  const auto attribute = [&](const char* name, const char* type, std::uint32_t size) {
    text(name);
    text(type);
    u32(size);
  };
  const auto box = [&](const char* name) {
    attribute(name, "box2i", 16);
    for (const std::uint32_t v : {0u, 0u, 2u, 1u}) u32(v);
  };
  u32(0x01312f76);
  u32(2 | 0x200);
  attribute("channels", "chlist", 2 + 16 + 1);
  text("Y");
  for (const std::uint32_t v : {1u, 0u, 1u, 1u}) u32(v);
  bytes.push_back(0);
  attribute("compression", "compression", 1);
  bytes.push_back(0);
  box("dataWindow");
  box("displayWindow");
  attribute("lineOrder", "lineOrder", 1);
  bytes.push_back(0);
  attribute("pixelAspectRatio", "float", 4);
  u32(std::bit_cast<std::uint32_t>(1.f));
  attribute("screenWindowCenter", "v2f", 8);
  u32(0);
  u32(0);
  attribute("screenWindowWidth", "float", 4);
  u32(std::bit_cast<std::uint32_t>(1.f));
  attribute("tiles", "tiledesc", 9);
  u32(2);
  u32(2);
  bytes.push_back(0);
  bytes.push_back(0);
  const auto first = static_cast<std::uint32_t>(bytes.size()) + 2 * 8;
  for (const std::uint32_t offset : {first, first + 20 + 8}) {
    u32(offset);
    u32(0);
  }
  for (const std::uint32_t x : {0u, 1u}) {  // the second tile is one pixel wide
    for (const std::uint32_t v : {x, 0u, 0u, 0u, x == 0 ? 8u : 4u}) u32(v);
    bytes.resize(bytes.size() + (x == 0 ? 8 : 4), 0x3c);
  }
  return bytes;
}

TEST_F(ImageFile, TiledExrFilesAreWholeByTheirTable) {
  const Bytes bytes = tiledExr();
  writeBytes("tiled.exr", bytes);
  EXPECT_EQ(readImage(path("tiled.exr")).width, 3);
  EXPECT_EQ(sizeOfWholeImage(path("tiled.exr")), Vec2i(3, 2));
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    writeBytes("tiled.exr", Bytes(bytes.begin(), bytes.begin() + static_cast<long>(length)));
    EXPECT_EQ(sizeOfWholeImage(path("tiled.exr")), std::nullopt) << length;
  }
}

TEST_F(ImageFile, DoubtfulFilesAreLeftToTheReader) {
  for (const char* name : {"none.png", "none", "a.bmp"})
    EXPECT_EQ(sizeOfWholeImage(path(name)), std::nullopt) << name;
  writeBytes("empty.exr", {});
  EXPECT_EQ(sizeOfWholeImage(path("empty.exr")), std::nullopt);
  fs::create_directory(path("folder.png"));
  EXPECT_EQ(sizeOfWholeImage(path("folder.png")), std::nullopt);
  // A pipe can be read once only.
  ASSERT_EQ(::mkfifo(path("pipe.png").c_str(), 0600), 0);
  EXPECT_EQ(sizeOfWholeImage(path("pipe.png")), std::nullopt);
  // Of another kind than the name says; without colour.
  writeImage(path("a.pfm"), ramp(3, 2));
  fs::rename(path("a.pfm"), path("a.exr"));
  EXPECT_EQ(sizeOfWholeImage(path("a.exr")), std::nullopt);
  LayeredImage depth;
  depth.displaySize = {2, 1};
  depth.dataWindow = {{0, 0}, {2, 1}};
  depth.channels = {{"Z", {1.f, 2.f}}};
  writeImage(path("z.exr"), depth);
  EXPECT_EQ(sizeOfWholeImage(path("z.exr")), std::nullopt);
}

TEST_F(ImageFile, FlippedBitsNeverChangeTheSizeThatTheHeadTells) {
  int whole = 0;
  for (const auto& [extension, original] : smallFiles(directory_.string()))
    for (std::size_t bit = 0; bit < 8 * original.size(); bit += 3) {
      Bytes bytes = original;
      bytes[bit / 8] = static_cast<unsigned char>(bytes[bit / 8] ^ (1u << bit % 8));
      writeBytes("flipped" + extension, bytes);
      const auto size = sizeOfWholeImage(path("flipped" + extension));
      if (!size) continue;
      ++whole;
      try {
        const Bounds2i window = decodeAny(extension, bytes).dataWindow;
        EXPECT_EQ(*size, Vec2i(window.width(), window.height())) << extension << " bit " << bit;
      } catch (const SceneError&) {  // found at the first lookup
      }
    }
  EXPECT_GT(whole, 100);
}

TEST_F(ImageFile, FlippedBitsNeverCrash) {
  for (const auto& [extension, original] : smallFiles(directory_.string())) {
    int rejected = 0;
    for (std::size_t bit = 0; bit < 8 * original.size(); ++bit) {
      Bytes bytes = original;
      bytes[bit / 8] = static_cast<unsigned char>(bytes[bit / 8] ^ (1u << bit % 8));
      try {
        const LayeredImage image = decodeAny(extension, bytes);
        EXPECT_LT(image.dataWindow.area(), 1 << 20) << extension << " bit " << bit;
      } catch (const SceneError&) {
        ++rejected;
      }
    }
    EXPECT_GT(rejected, 8) << extension;
    // Checksums cover all of a PNG file behind its signature.
    if (extension == ".png") {
      EXPECT_EQ(rejected, static_cast<int>(8 * original.size()));
    }
  }
}

TEST_F(ImageFile, OversizedHeadersAreRefusedBeforeAllocation) {
  const std::string huge = "PF\n100000 100000\n-1\n0000";
  writeBytes("huge.pfm", Bytes(huge.begin(), huge.end()));
  EXPECT_THAT(errorOf([&] { readImage(path("huge.pfm")); }),
              HasSubstr("100000 x 100000 pixels need 111.8 GiB; the limits are"));
  const std::string hollow = "PF\n10000 10000\n-1\n0000";
  writeBytes("hollow.pfm", Bytes(hollow.begin(), hollow.end()));
  EXPECT_THAT(errorOf([&] { readImage(path("hollow.pfm")); }),
              HasSubstr("the header promises 10000 x 10000 pixels (1.1 GiB)"));

  // The data window of an EXR file, patched in place.
  writeImage(path("a.exr"), ramp(3, 2));
  Bytes bytes = fileBytes(path("a.exr"));
  const std::string key = "dataWindow";
  const auto at = std::search(bytes.begin(), bytes.end(), key.begin(), key.end());
  const auto offset = at - bytes.begin() + 11 + 6 + 4;
  for (int i = 8; i < 16; i += 4) bytes[static_cast<std::size_t>(offset + i + 2)] = 3;
  writeBytes("a.exr", bytes);
  EXPECT_THAT(errorOf([&] { readImage(path("a.exr")); }),
              HasSubstr("pixels need 432.0 GiB; the limits are"));
}

TEST_F(ImageFile, ErrorsHelp) {
  writeImage(path("lines.exr"), ramp(2, 2));
  EXPECT_EQ(errorOf([&] { readImage(path("lnies.exr")); }),
            "cannot open '" + path("lnies.exr") + "': no such file (did you mean 'lines.exr'?)");
  EXPECT_THAT(errorOf([&] { readImage(path("no/a.exr")); }), HasSubstr("does not exist"));
  EXPECT_EQ(
      errorOf([&] { readImage("a.jpgg"); }),
      "cannot read image 'a.jpgg': unknown image format '.jpgg' (did you mean '.jpg'?); brume "
      "reads '.exr', '.png', '.pfm', '.tga', '.jpg', '.jpeg' or '.hdr'");
  EXPECT_THAT(errorOf([&] { readImage("image"); }), HasSubstr("the name has no extension"));
  writeBytes("empty.png", {});
  EXPECT_THAT(errorOf([&] { readImage(path("empty.png")); }), HasSubstr("the file is empty"));
  writeBytes("foreign.exr", {'B', 'M', 1, 2, 3, 4, 5, 6});
  EXPECT_THAT(errorOf([&] { readImage(path("foreign.exr")); }), HasSubstr("not an OpenEXR file"));
  fs::create_directory(path("dir.exr"));
  EXPECT_THAT(errorOf([&] { readImage(path("dir.exr")); }), HasSubstr("is a directory"));

  static const std::string file = "scene.pbrt";
  try {
    readImage("missing.exr", SourceLocation{&file, 3, 4});
    FAIL();
  } catch (const SceneError& e) {
    EXPECT_EQ(e.where().line, 3u);
  }
}

TEST_F(ImageFile, WritesWholeOrNotAtAll) {
  EXPECT_TRUE(isWritableImageName("a.EXR"));
  EXPECT_FALSE(isWritableImageName("a.jpg"));
  EXPECT_THAT(errorOf([&] { writeImage(path("a.jpg"), ramp(1, 1)); }),
              HasSubstr("brume writes '.exr', '.png', '.pfm' or '.tga'"));
  EXPECT_NO_THROW(checkWritable(path("a.exr")));
  EXPECT_EQ(fileCount(), 0u);
  EXPECT_THAT(errorOf([&] { checkWritable(path("no/a.exr")); }), HasSubstr("No such file"));
  EXPECT_THAT(errorOf([&] { checkWritable(path("a.exr"), ~std::uint64_t{0}); }),
              HasSubstr("16.0 EiB are needed"));
  { const AtomicFile abandoned(path("b.exr")); }
  EXPECT_EQ(fileCount(), 0u);

  // The target of a link is replaced, not the link.
  writeImage(path("real.pfm"), ramp(1, 1));
  fs::create_symlink("real.pfm", path("link.pfm"));
  writeImage(path("link.pfm"), ramp(2, 2));
  EXPECT_TRUE(fs::is_symlink(path("link.pfm")));
  EXPECT_EQ(readImage(path("real.pfm")).width, 2);
  EXPECT_EQ(fileCount(), 2u);
}

TEST_F(ImageFile, DevicesAreNotReplaced) {
  fs::create_symlink("/dev/null", path("null.exr"));
  EXPECT_THAT(errorOf([&] { writeImage(path("null.exr"), ramp(2, 2)); }),
              HasSubstr("not a regular file"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(ImageFile, AFailingWriteLeavesTheOldFile) {
  writeImage(path("a.exr"), ramp(2, 2));
  // A limit on the size of files stands for a full disk; both fail in write().
  const auto oldHandler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit old{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old), 0);
  for (const rlim_t limit : {0, 100, 400, 600}) {
    const rlimit small{limit, old.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    const std::string error = errorOf([&] { writeImage(path("a.exr"), ramp(64, 64)); });
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &old), 0);
    EXPECT_THAT(error, HasSubstr("File too large")) << limit;
  }
  std::signal(SIGXFSZ, oldHandler);
  EXPECT_EQ(readImage(path("a.exr")).width, 2);
  EXPECT_EQ(fileCount(), 1u);
}

}  // namespace
}  // namespace brume
