// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "core/deferred.h"
#include "core/file_cache.h"
#include "core/io/image.h"
#include "core/noise.h"
#include "support/make_plugin.h"
#include "textures/mapping.h"

namespace brume {
namespace {

using namespace test;
using testing::HasSubstr;

TextureContext atUv(float u, float v) {
  TextureContext at;
  at.uv = {u, v};
  return at;
}
TextureContext atPoint(const Vec3& p) {
  TextureContext at;
  at.p = p;
  return at;
}
TextureFactoryContext withCtm(const Transform& ctm) {
  TextureFactoryContext context;
  context.textureToScene = ctm;
  return context;
}

/// Two named textures for texture parameters: "u" is the u coordinate.
class UTexture final : public Texture<float> {
 public:
  float evaluate(const TextureContext& at) const override { return at.uv.x; }
};
class RgbUTexture final : public Texture<Rgb> {
 public:
  Rgb evaluate(const TextureContext& at) const override { return {at.uv.x, 0, 1}; }
};
class NamedTextures final : public TextureLookup {
 public:
  const Texture<float>* findFloatTexture(const std::string& name) override {
    return name == "u" ? &u_ : nullptr;
  }
  const Texture<Rgb>* findRgbTexture(const std::string& name) override {
    return name == "u" ? &rgb_ : nullptr;
  }
  std::vector<std::string> textureNames(bool) const override { return {"u"}; }

 private:
  UTexture u_;
  RgbUTexture rgb_;
};

std::unique_ptr<Texture<float>> makeFloat(std::string_view name, std::vector<Param> params,
                                          const TextureFactoryContext& context = {}) {
  static NamedTextures named;
  return make<Texture<float>>(name, std::move(params), context, &named);
}
std::unique_ptr<Texture<Rgb>> makeRgb(std::string_view name, std::vector<Param> params,
                                      const TextureFactoryContext& context = {}) {
  static NamedTextures named;
  return make<Texture<Rgb>>(name, std::move(params), context, &named);
}

TEST(Textures, ConstantScaleAndMix) {
  EXPECT_EQ(makeFloat("constant", {})->evaluate({}), 1);
  EXPECT_EQ(makeRgb("constant", {color("value", {1, 2, 3})})->evaluate({}), Rgb(1, 2, 3));
  EXPECT_EQ(makeFloat("scale", {texture("tex1", "u"), floats("tex2", {3})})->evaluate(atUv(.5f, 0)),
            1.5f);
  EXPECT_EQ(
      makeRgb("scale", {texture("tex1", "u"), color("tex2", {2, 2, .5f})})->evaluate(atUv(.5f, 0)),
      Rgb(1, 0, .5f));
  EXPECT_EQ(makeFloat("mix", {})->evaluate({}), .5f);
  EXPECT_EQ(makeFloat("mix", {floats("tex1", {2}), floats("tex2", {4}), texture("amount", "u")})
                ->evaluate(atUv(.25f, 0)),
            2.5f);
  EXPECT_EQ(makeRgb("mix", {texture("tex2", "u"), floats("amount", {1})})->evaluate(atUv(.25f, 0)),
            Rgb(.25f, 0, 1));
}

TEST(Textures, BilerpNamesItsCornersByStFirst) {
  const auto corners = makeFloat(
      "bilerp", {floats("v00", {1}), floats("v01", {2}), floats("v10", {3}), floats("v11", {4})});
  EXPECT_EQ(corners->evaluate(atUv(0, 0)), 1);
  EXPECT_EQ(corners->evaluate(atUv(0, 1)), 2);
  EXPECT_EQ(corners->evaluate(atUv(1, 0)), 3);
  EXPECT_EQ(corners->evaluate(atUv(1, 1)), 4);
  EXPECT_EQ(corners->evaluate(atUv(.5f, .5f)), 2.5f);
  EXPECT_EQ(makeRgb("bilerp", {})->evaluate(atUv(.2f, .75f)), Rgb(.75f));
}

TEST(Textures, UvIsTheFraction) {
  const auto uv = makeRgb("uv", {floats("uscale", {2}), floats("vdelta", {-1.25f})});
  const Rgb value = uv->evaluate(atUv(.75f, .5f));
  EXPECT_EQ(value, Rgb(.5f, .25f, 0));
}

TEST(Textures, SpectrumOnlyTexturesAreUnknownAsFloat) {
  EXPECT_EQ(makeFloat("uv", {}), nullptr);
  EXPECT_EQ(makeFloat("marble", {}), nullptr);
  for (const char* name :
       {"constant", "scale", "mix", "bilerp", "checkerboard", "dots", "fbm", "wrinkled", "windy"}) {
    EXPECT_NE(makeFloat(name, {}), nullptr) << name;
    EXPECT_NE(makeRgb(name, {}), nullptr) << name;
  }
}

TEST(Checkerboard, PointSampled) {
  const auto checks = makeFloat("checkerboard", {string("aamode", "none")});
  EXPECT_EQ(checks->evaluate(atUv(.5f, .5f)), 1);
  EXPECT_EQ(checks->evaluate(atUv(1.5f, .5f)), 0);
  EXPECT_EQ(checks->evaluate(atUv(1.5f, -.5f)), 1);
  EXPECT_EQ(checks->evaluate(atUv(-.5f, .5f)), 0);
  EXPECT_EQ(checks->evaluate(atUv(1e20f, .5f)), 1);
}

TEST(Checkerboard, ClosedFormIsTheMeanOverTheBox) {
  const auto filtered = makeFloat("checkerboard", {});
  const auto sharp = makeFloat("checkerboard", {string("aamode", "none")});
  for (const auto& [s, t, ds, dt] : {std::array{.9f, .4f, .3f, .05f},
                                     {1.1f, 2.95f, .45f, .8f},
                                     {-.2f, 3.f, .9f, .0f},
                                     {.99f, .01f, 0.f, .5f},
                                     {2.5f, .5f, 1.f, 1.f}}) {
    TextureContext at = atUv(s, t);
    at.dudx = ds;
    at.dvdy = -dt;
    constexpr int kSteps = 400;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i)
      for (int j = 0; j < kSteps; ++j) {
        const auto offset = [](int k) { return 2 * (static_cast<float>(k) + .5f) / kSteps - 1; };
        sum += sharp->evaluate(atUv(s + offset(i) * ds, t + offset(j) * dt));
      }
    // The grid misses an edge by at most a step in each direction.
    EXPECT_NEAR(filtered->evaluate(at), sum / kSteps / kSteps, 4. / kSteps) << s << ' ' << t;
  }
  TextureContext wide = atUv(.3f, .4f);
  wide.dudx = 1.5f;
  EXPECT_EQ(filtered->evaluate(wide), .5f);
}

TEST(Checkerboard, SolidUsesTheCtmItself) {
  const auto checks =
      makeFloat("checkerboard", {integers("dimension", {3})}, withCtm(Transform::scale(2, 1, 1)));
  EXPECT_EQ(checks->evaluate(atPoint({.25f, .5f, .5f})), 1);
  EXPECT_EQ(checks->evaluate(atPoint({.75f, .5f, .5f})), 0);
  EXPECT_EQ(checks->evaluate(atPoint({.75f, .5f, -.5f})), 1);
  EXPECT_THROW(makeFloat("checkerboard", {integers("dimension", {4})}), SceneError);
}

TEST(Dots, ExchangesInsideAndOutside) {
  const auto dots = makeFloat("dots", {floats("inside", {5}), floats("outside", {7})});
  int inDots = 0, total = 0, cellsWithDot = 0;
  for (int cell = 0; cell < 400; ++cell) {
    const float s = static_cast<float>(cell % 20), t = static_cast<float>(cell / 20);
    int hits = 0;
    for (int i = 0; i < 400; ++i, ++total) {
      const float x = s - .5f + (static_cast<float>(i % 20) + .5f) / 20;
      const float y = t - .5f + (static_cast<float>(i / 20) + .5f) / 20;
      const float value = dots->evaluate(atUv(x, y));
      ASSERT_TRUE(value == 5 || value == 7);
      hits += value == 7;
    }
    // A cell has a whole dot or none: area pi 0.35^2 = 0.385, to the grid of 20 x 20.
    EXPECT_TRUE(hits == 0 || std::abs(hits / 400. - .385) < .03) << hits;
    cellsWithDot += hits > 0;
    inDots += hits;
  }
  EXPECT_NEAR(cellsWithDot / 400., .5, .1);
  EXPECT_NEAR(inDots / static_cast<double>(total), .385 * cellsWithDot / 400., .01);
}

TEST(SolidNoise, FollowsTheFunctionsOfNoise) {
  const Transform ctm = Transform::translate({1, 2, 3}) * Transform::scale(2, 2, 2);
  TextureContext at = atPoint({.3f, -.4f, .9f});
  at.dpdx = {.01f, 0, 0};
  at.dpdy = {0, .02f, 0};
  const Vec3 p = ctm.point(at.p), dx = ctm.vector(at.dpdx), dy = ctm.vector(at.dpdy);
  const std::vector<Param> params{integers("octaves", {5}), floats("roughness", {.6f})};
  EXPECT_EQ(makeFloat("fbm", params, withCtm(ctm))->evaluate(at), fbm(p, dx, dy, .6f, 5));
  EXPECT_EQ(makeRgb("wrinkled", params, withCtm(ctm))->evaluate(at),
            Rgb(turbulence(p, dx, dy, .6f, 5)));
  EXPECT_EQ(makeFloat("windy", {}, withCtm(ctm))->evaluate(at),
            std::abs(fbm(.1f * p, .1f * dx, .1f * dy, .5f, 3)) * fbm(p, dx, dy, .5f, 6));
}

TEST(Marble, IsASplineAlongY) {
  // Without noise the colour depends on y alone.
  const auto marble = makeRgb("marble", {floats("variation", {0})});
  EXPECT_EQ(marble->evaluate(atPoint({1, 2, 3})), marble->evaluate(atPoint({-5, 2, 8})));
  // t = 0: the first three control colours are equal. t = 1: the last curve ends at its last
  // colour.
  const auto near = [](const Rgb& a, const Rgb& b) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 1e-4f);
  };
  near(marble->evaluate(atPoint({0, -.5f * kPi, 0})), 1.5f * Rgb(.58f, .58f, .6f));
  near(marble->evaluate(atPoint({0, .5f * kPi, 0})), 1.5f * Rgb(.58f, .58f, .6f));
  // t = 1/2 is the start of the fourth curve.
  near(marble->evaluate(atPoint({0, 0, 0})), 1.5f * Rgb(.5f, .5f, .5f));
  for (int i = 0; i < 1000; ++i) {
    const Rgb value =
        makeRgb("marble", {})
            ->evaluate(atPoint({.1f * static_cast<float>(i), .37f * static_cast<float>(i), 0}));
    EXPECT_GE(value.minChannel(), 1.5f * .2f);
    EXPECT_LE(value.maxChannel(), 1.5f * .6f + 1e-5f);
    if (i == 50) break;
  }
}

TEST(Mapping, ClosedFormsAndSpaces) {
  TextureFactoryContext context = withCtm(Transform::translate({1, 0, 0}));
  Mapping2D::Params params;
  params.kind = Mapping2D::Kind::Spherical;
  // Texture space is the inverse of the CTM: the centre of the sphere is at (1, 0, 0).
  const Mapping2D sphere(params, context);
  Vec2 st = sphere(atPoint({1, 2, 0})).st;
  EXPECT_NEAR(st.x, .5f, 1e-6f);
  EXPECT_NEAR(st.y, .25f, 1e-6f);
  st = sphere(atPoint({1, -2, 0})).st;
  EXPECT_NEAR(st.y, .75f, 1e-6f);
  st = sphere(atPoint({1, 0, -3})).st;
  EXPECT_NEAR(st.x, 1, 1e-6f);
  EXPECT_TRUE(std::isfinite(sphere(atPoint({1, 0, 0})).st.x));

  params.kind = Mapping2D::Kind::Cylindrical;
  const Mapping2D cylinder(params, context);
  st = cylinder(atPoint({2, 0, 1})).st;
  EXPECT_NEAR(st.x, .5f, 1e-6f);
  EXPECT_NEAR(st.y, std::sqrt(.5f), 1e-6f);  // the height of the normalised position

  params.kind = Mapping2D::Kind::Planar;
  params.v1 = {2, 0, 0};
  params.v2 = {0, 0, 1};
  params.udelta = .5f;
  const TexturePoint2 q = Mapping2D(params, context)(atPoint({3, 4, 5}));
  EXPECT_EQ(q.st, Vec2(6.5f, 5.f));  // scene space: the CTM does not matter
}

TEST(Mapping, DerivativesAreFiniteDifferences) {
  const Transform ctm = Transform::rotate(30, {1, 2, 3}) * Transform::scale(1, 2, 1);
  for (const auto kind : {Mapping2D::Kind::Uv, Mapping2D::Kind::Spherical,
                          Mapping2D::Kind::Cylindrical, Mapping2D::Kind::Planar}) {
    Mapping2D::Params params;
    params.kind = kind;
    if (kind == Mapping2D::Kind::Uv) params.uscale = 3;
    const Mapping2D map(params, withCtm(ctm));
    TextureContext at = atPoint({.7f, .5f, 1.2f});
    at.uv = {.2f, .3f};
    at.dpdx = {.01f, .02f, -.01f};
    at.dpdy = {-.02f, .005f, .01f};
    at.dudx = .01f;
    at.dvdx = -.02f;
    at.dudy = .03f;
    at.dvdy = .005f;
    TextureContext next = at;
    next.p += at.dpdx;
    next.uv += Vec2(at.dudx, at.dvdx);
    const TexturePoint2 here = map(at), there = map(next);
    // First order against a whole step of 2 % of the distance: 5 % of the change.
    const Vec2 change = there.st - here.st;
    EXPECT_NEAR(here.dstdx.x, change.x, .05f * std::abs(change.x) + 1e-4f);
    EXPECT_NEAR(here.dstdx.y, change.y, .05f * std::abs(change.y) + 1e-4f);
    EXPECT_GT(std::abs(here.dstdy.x) + std::abs(here.dstdy.y), 1e-3f);
  }
}

TEST(Mapping, UnusedParametersWarn) {
  Log log(Log::Options{Verbosity::Normal, false, true});
  TextureFactoryContext context;
  context.log = &log;
  Mapping2D::Params params;
  params.kind = Mapping2D::Kind::Spherical;
  params.uscale = 2;
  params.v1 = {0, 0, 1};
  const Mapping2D map(params, context);
  ASSERT_EQ(log.warningCount(), 1);
  EXPECT_THAT(log.captured().at(0), HasSubstr("uscale, vscale, v1, v2 have no effect"));
}

class ImageMap : public ::testing::Test {
 protected:
  void SetUp() override {
    directory_ =
        std::filesystem::temp_directory_path() / ("brume-texture-" + std::to_string(::getpid()));
    std::filesystem::create_directories(directory_);
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }
  std::string path(const std::string& name) const { return (directory_ / name).string(); }
  std::filesystem::path directory_;
};

TEST_F(ImageMap, RowOrderScaleAndGamma) {
  RgbImage image(2, 2);
  image.pixels = {Rgb(.1f), Rgb(.2f), Rgb(.3f), Rgb(.4f, .5f, .6f)};
  writeImage(path("a.exr"), image);
  writeImage(path("a.pfm"), image);
  const auto top = atUv(.25f, .25f), low = atUv(.75f, .75f);
  const auto exr = makeRgb("imagemap", {string("filename", path("a.exr"))});
  EXPECT_EQ(exr->evaluate(top), Rgb(.1f));
  EXPECT_EQ(exr->evaluate(low), Rgb(.4f, .5f, .6f));
  const auto pfm = makeRgb("imagemap", {string("filename", path("a.pfm"))});
  EXPECT_EQ(pfm->evaluate(top), Rgb(.3f));
  EXPECT_EQ(pfm->evaluate(low), Rgb(.2f));
  const auto grey = makeFloat(
      "imagemap", {string("filename", path("a.exr")), floats("scale", {2}), floats("gamma", {3})});
  EXPECT_FLOAT_EQ(grey->evaluate(low), std::pow(2 * Rgb(.4f, .5f, .6f).luminance(), 3.f));
}

/// Textures of one file with different scales, in one scene.
class TexturesOfAScene {
 public:
  std::unique_ptr<Texture<Rgb>> make(const std::string& file, float scale) {
    TextureFactoryContext context;
    context.files = &files_;
    return makeRgb("imagemap", {string("filename", file), floats("scale", {scale})}, context);
  }
  DeferredCounts count() { return DeferredFiles::of(files_).count(); }

 private:
  FileCache files_;
};

TEST_F(ImageMap, TexturesOfOneFileShareIt) {
  RgbImage image(1, 1);
  image.pixels = {Rgb(.25f)};
  writeImage(path("one.exr"), image);
  TexturesOfAScene scene;
  const auto first = scene.make(path("one.exr"), 1), same = scene.make(path("one.exr"), 1),
             scaled = scene.make(path("one.exr"), 2);
  EXPECT_EQ(scene.count().unread, 1u);
  EXPECT_EQ(scene.count().bytesUnread, 2 * 16.);  // two pyramids of a texel, and a third of it
  EXPECT_EQ(first->evaluate({}), Rgb(.25f));
  std::filesystem::remove(path("one.exr"));  // it is not read again
  EXPECT_EQ(same->evaluate({}), Rgb(.25f));
  EXPECT_EQ(scaled->evaluate({}), Rgb(.5f));
  EXPECT_EQ(scene.count().read, 1u);
  EXPECT_EQ(scene.count().bytesUnread, 0);
}

TEST_F(ImageMap, FilesAreReadAtTheFirstLookup) {
  RgbImage image(64, 64);
  for (Rgb& pixel : image.pixels) pixel = Rgb(.5f);
  for (const char* name : {"a.exr", "a.pfm", "a.png", "a.tga"}) {
    writeImage(path(name), image);
    TexturesOfAScene scene;
    const auto unused = scene.make(path(name), 1), used = scene.make(path(name), 2);
    EXPECT_EQ(scene.count().unread, 1u) << name;
    // Whole as it was when the scene was read; now it is gone.
    std::filesystem::remove(path(name));
    for (int i = 0; i < 2; ++i) try {
        used->evaluate({});
        ADD_FAILURE() << name;
      } catch (const SceneError& error) {
        EXPECT_THAT(error.what(), HasSubstr("no such file")) << "the same error at every lookup";
      }
    EXPECT_EQ(scene.count().unread, 1u);
  }
}

TEST_F(ImageMap, PipesAreReadAtOnce) {
  RgbImage image(1, 1);
  image.pixels = {Rgb(.25f)};
  writeImage(path("one.pfm"), image);
  ASSERT_EQ(::mkfifo(path("pipe.pfm").c_str(), 0600), 0);
  std::thread writer([&] {
    std::ofstream(path("pipe.pfm"), std::ios::binary)
        << std::ifstream(path("one.pfm"), std::ios::binary).rdbuf();
  });
  TexturesOfAScene scene;
  const auto texture = scene.make(path("pipe.pfm"), 1), scaled = scene.make(path("pipe.pfm"), 2);
  writer.join();
  EXPECT_EQ(scene.count().read, 1u);
  EXPECT_EQ(texture->evaluate({}), Rgb(.25f));
  EXPECT_EQ(scaled->evaluate({}), Rgb(.5f));
}

TEST_F(ImageMap, FiltersOverTheFootprint) {
  RgbImage image(64, 64);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) image.at(x, y) = Rgb(x % 2 ? 1.f : 0.f);
  writeImage(path("stripes.exr"), image);
  TextureContext at = atUv(.5f / 64, .5f);
  for (const bool trilinear : {false, true}) {
    const auto map = makeFloat(
        "imagemap", {string("filename", path("stripes.exr")), boolean("trilinear", trilinear)});
    at.dudx = at.dvdy = 0;
    EXPECT_EQ(map->evaluate(at), 0);
    at.dudx = at.dvdy = .1f;
    EXPECT_NEAR(map->evaluate(at), 1, .51f);  // luminance weights sum to 1
    EXPECT_NEAR(map->evaluate(at), .5f, 1e-5f);
  }
}

TEST_F(ImageMap, ErrorsHelp) {
  const auto errorOf = [&](std::vector<Param> params) -> std::string {
    try {
      makeRgb("imagemap", std::move(params));
    } catch (const SceneError& e) {
      return e.what();
    }
    return "none";
  };
  writeImage(path("lines.exr"), RgbImage(1, 1));
  EXPECT_THAT(errorOf({}), HasSubstr("needs \"string filename\""));
  EXPECT_THAT(errorOf({string("filename", path("line.exr"))}),
              HasSubstr("did you mean 'lines.exr'?"));
  EXPECT_THAT(errorOf({string("filename", path("lines.ext"))}), HasSubstr("did you mean '.exr'?"));
  EXPECT_NE(errorOf({string("filename", path("lines.exr")), string("wrap", "mirror")}), "none");
  EXPECT_NE(errorOf({string("filename", path("lines.exr")), floats("maxanisotropy", {.5f})}),
            "none");
}

TEST_F(ImageMap, EndsOfRanges) {
  writeImage(path("one.exr"), RgbImage(1, 1));
  for (const float anisotropy : {1.f, 1024.f})
    for (const float gamma : {1e-30f, 1e30f})
      for (const char* wrap : {"repeat", "black", "clamp"})
        EXPECT_TRUE(
            makeRgb("imagemap", {string("filename", path("one.exr")), string("wrap", wrap),
                                 floats("maxanisotropy", {anisotropy}), floats("gamma", {gamma})})
                ->evaluate(atUv(.1f, .2f))
                .isFinite());
}

TEST(Textures, EndsOfRangesStayFinite) {
  for (const char* name : {"fbm", "wrinkled", "marble"})
    for (const int octaves : {0, 32})
      for (const float roughness : {-10.f, 10.f}) {
        const auto map =
            makeRgb(name, {integers("octaves", {octaves}), floats("roughness", {roughness})});
        EXPECT_TRUE(map->evaluate(atPoint({.3f, .4f, .5f})).isFinite()) << name;
      }
  const float huge = std::numeric_limits<float>::max();
  for (const float extreme : {-huge, huge}) {
    EXPECT_TRUE(makeRgb("marble", {floats("scale", {extreme}), floats("variation", {extreme})})
                    ->evaluate(atPoint({1, 2, 3}))
                    .isFinite());
    for (const char* mapping : {"uv", "spherical", "cylindrical", "planar"}) {
      EXPECT_NO_THROW(makeFloat("dots", {string("mapping", mapping), floats("uscale", {extreme}),
                                         floats("udelta", {extreme})})
                          ->evaluate(atUv(.5f, .5f)));
      const float check =
          makeFloat("checkerboard", {string("mapping", mapping), floats("vscale", {extreme}),
                                     floats("vdelta", {extreme})})
              ->evaluate(atUv(.5f, .5f));
      EXPECT_TRUE(check >= 0 && check <= 1);
    }
  }
  EXPECT_THROW(makeFloat("fbm", {integers("octaves", {33})}), SceneError);
  EXPECT_THROW(makeFloat("fbm", {integers("octaves", {-1})}), SceneError);
}

}  // namespace
}  // namespace brume
