// SPDX-License-Identifier: Apache-2.0
// Files of textures that are read while the image is rendered: what is found wrong then is told as
// it would have been before.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/image.h"
#include "core/rng.h"
#include "support/run_program.h"

namespace brume::test {
namespace {

using testing::HasSubstr;
using testing::Not;

class LateFiles : public testing::Test {
 protected:
  LateFiles() {
    RgbImage image(64, 64);
    Rng rng(1);
    for (Rgb& pixel : image.pixels) pixel = Rgb(rng.uniform());
    writeImage(path("whole.png"), image);
    // A wrong byte in the middle: head and end are as they should be.
    std::string bytes = readFile(path("whole.png"));
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x55);
    folder_.write("broken.png", bytes);
    folder_.write("other.png", bytes);
  }
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  /// Disks with textures "a" and "b" before a wall, seen by few samples when small.
  void write(const std::string& a, const std::string& b, const std::string& radius,
             const std::string& integrator = "SurfaceIntegrator \"directlighting\"") const {
    folder_.write("scene.pbrt",
                  "Film \"image\" \"integer xresolution\" 32 \"integer yresolution\" 96\n"
                  "Sampler \"random\" \"integer pixelsamples\" 256\n"
                  "LookAt 0 0 -5  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" 40\n" +
                      integrator +
                      "\nWorldBegin\n"
                      "LightSource \"point\" \"point from\" [0 0 -9] \"color I\" [99 99 99]\n"
                      "Texture \"a\" \"color\" \"imagemap\" \"string filename\" \"" +
                      a + "\"\nTexture \"b\" \"color\" \"imagemap\" \"string filename\" \"" + b +
                      "\"\nShape \"trianglemesh\" \"integer indices\" [0 1 2] "
                      "\"point P\" [-99 -99 1  0 99 1  99 -99 1]\n"
                      "Translate 0 -.5 0 Material \"matte\" \"texture Kd\" \"a\"\n"
                      "Shape \"disk\" \"float radius\" " +
                      radius +
                      "\nTranslate 0 3 0 Material \"matte\" \"texture Kd\" \"b\"\n"
                      "Shape \"disk\" \"float radius\" .4\nWorldEnd\n");
  }
  ProgramResult run(std::vector<std::string> arguments) const {
    arguments.push_back("scene.pbrt");
    return runBrume({arguments, folder_.path()});
  }
  TemporaryFolder folder_;
};

TEST_F(LateFiles, ABrokenOneIsToldWithItsPlace) {
  write("broken.png", "whole.png", ".4");
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"-o", "image.exr"}, {"--check"}}) {
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.exitCode, 1);
    EXPECT_THAT(result.err,
                HasSubstr("scene.pbrt:8:32: error: cannot read image 'broken.png': corrupt PNG "
                          "file: wrong checksum of the chunk at byte "));
    EXPECT_FALSE(std::filesystem::exists(path("image.exr"))) << "nothing was finished";
  }
}

TEST_F(LateFiles, NobodyMindsOneThatNoRayMeets) {
  write("broken.png", "whole.png", "0.00001");
  EXPECT_EQ(run({"-o", "image.exr", "--spp", "1"}).exitCode, 0);
  EXPECT_EQ(run({"--check"}).exitCode, 1) << "but by the check";
}

TEST_F(LateFiles, WhatWasFinishedIsKept) {
  // A sample in 4,000 or so meets the disk, none of the first portion does.
  write("broken.png", "whole.png", ".012");
  const ProgramResult result = run({"-o", "image.exr"});
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_THAT(result.err, HasSubstr("samples per pixel; wrote what was finished to image.exr"));
  EXPECT_THAT(result.err, HasSubstr("error: cannot read image 'broken.png'"));
  const RgbImage image = readImage(path("image.exr"));
  for (const Rgb& pixel : image.pixels) EXPECT_GT(pixel.g, 0);
}

TEST_F(LateFiles, AnOldImageStaysWhenNothingWasFinished) {
  write("whole.png", "whole.png", ".4");
  ASSERT_EQ(run({"-o", "image.exr", "--spp", "1"}).exitCode, 0);
  const std::string before = readFile(path("image.exr"));
  write("broken.png", "whole.png", ".4");
  EXPECT_EQ(run({"-o", "image.exr"}).exitCode, 1);
  EXPECT_EQ(readFile(path("image.exr")), before);
}

TEST_F(LateFiles, OfTwoTheSameIsToldByAnyNumberOfThreads) {
  write("broken.png", "other.png", ".4");
  for (int repetition = 0; repetition < 3; ++repetition)
    for (const char* threads : {"1", "2", "7"}) {
      const ProgramResult result = run({"-o", "image.exr", "--threads", threads});
      EXPECT_EQ(result.exitCode, 1);
      EXPECT_THAT(result.err, HasSubstr("'other.png'")) << "the upper disk comes first";
      EXPECT_THAT(result.err, Not(HasSubstr("'broken.png'")));
    }
}

TEST_F(LateFiles, EveryIntegratorEndsLikewise) {
  for (const char* integrator :
       {"whitted", "path", "photonmap:causticphotons=0,indirectphotons=1000,finalgather=false",
        "volpath", "bre:photons=100,surfacephotons=1000", "vpm:photons=100,surfacephotons=1000",
        "pvpm:photonsperpass=1000"}) {
    write("broken.png", "whole.png", ".4");
    const ProgramResult result =
        run({"-o", "image.exr", "--passes", "2", "--threads", "3", "--integrator", integrator});
    EXPECT_EQ(result.exitCode, 1) << integrator;
    EXPECT_THAT(result.err, HasSubstr("scene.pbrt:8:32: error: cannot read image 'broken.png'"))
        << integrator;
  }
}

TEST_F(LateFiles, AnAlphaTextureMayBeBrokenToo) {
  for (const char* motion : {"", "ActiveTransform EndTime Translate .1 0 0 ActiveTransform All "}) {
    const std::string object =
        "Texture \"cut\" \"float\" \"imagemap\" \"string filename\" \"broken.png\"\n"
        "ObjectBegin \"o\" Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [-1 -1 0 "
        " "
        "0 1 0  1 -1 0] \"texture alpha\" \"cut\" ObjectEnd\n";
    folder_.write("scene.pbrt",
                  "Film \"image\" \"integer xresolution\" 16 \"integer yresolution\" 16\n"
                  "LookAt 0 0 -5  0 0 0  0 1 0\nCamera \"perspective\"\nWorldBegin\n"
                  "LightSource \"point\" \"point from\" [0 0 -9]\n" +
                      object + motion + "ObjectInstance \"o\"\nWorldEnd\n");
    const ProgramResult result = run({"-o", "image.exr"});
    EXPECT_EQ(result.exitCode, 1) << motion;
    EXPECT_THAT(result.err, HasSubstr("scene.pbrt:6:34: error: cannot read image 'broken.png'"))
        << motion;
  }
}

}  // namespace
}  // namespace brume::test
