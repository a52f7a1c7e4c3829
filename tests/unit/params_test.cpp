// SPDX-License-Identifier: Apache-2.0
#include "core/params.h"

#include <gmock/gmock.h>

#include "core/registry.h"
#include "support/make_plugin.h"

namespace brume {
namespace {

using namespace test;
using testing::HasSubstr;

enum class Mode { All, One };

/// One parameter of every kind that a plugin can declare.
struct Everything {
  float radius = 1;
  std::optional<float> zmin;
  int samples = 4;
  bool jitter = true;
  std::string label = "none";
  Filename file;
  Mode mode = Mode::One;
  Rgb tint{.5f};
  Vec3 from{0}, up{0, 1, 0};
  FloatSlot sigma;
  RgbSlot Kd{Rgb(.25f), nullptr};
  std::vector<float> density;
  std::optional<std::array<float, 4>> window;
  std::vector<int> indices;
  std::vector<Vec3> P;
  std::vector<std::string> words;

  void visit(ParamVisitor& v) {
    v(radius, "radius", kPositive, Unit::Length, "a radius");
    v(zmin, "zmin", kAnyFloat, Unit::Length, "lower end");
    v(samples, "samples", kPositiveInt, Unit::Samples, "how many");
    v(jitter, "jitter", "whether");
    v(label, "label", "a word");
    v(file, "file", "a file");
    v(mode, "mode", {{"all", Mode::All}, {"one", Mode::One}}, "a choice");
    v(tint, "tint", kNonNegative, Unit::None, "a colour");
    v.point(from, "from", Unit::Length, "a point");
    v.vector(up, "up", Unit::None, "a vector");
    v(sigma, "sigma", kNonNegative, Unit::Degrees, "a float texture");
    v(Kd, "Kd", kNonNegative, Unit::None, "a colour texture");
    v(density, "density", kNonNegative, Unit::None, "a list");
    v(window, "window", kAnyFloat, Unit::None, "four numbers");
    v.alias("index", "indices");
    v(indices, "indices", kNonNegativeInt, Unit::None, "integers");
    v.points(P, "P", "points");
    v(words, "words", "strings");
  }
};

class OneTexture final : public Texture<float> {
 public:
  float evaluate(const TextureContext&) const override { return 7; }
};

class Lookup final : public TextureLookup {
 public:
  const Texture<float>* findFloatTexture(const std::string& name) override {
    return name == "bumps" ? &texture_ : nullptr;
  }
  const Texture<Rgb>* findRgbTexture(const std::string&) override { return nullptr; }
  std::vector<std::string> textureNames(bool isFloat) const override {
    return isFloat ? std::vector<std::string>{"bumps"} : std::vector<std::string>{"lines"};
  }

 private:
  OneTexture texture_;
};

Everything read(std::vector<Param> params) {
  static Lookup lookup;
  ParamSet set = paramSet(std::move(params));
  ParamReader reader({&set}, "everything", "dir", &lookup, captureLog());
  Everything e;
  e.visit(reader);
  return e;
}

std::string errorOf(std::vector<Param> params) {
  try {
    read(std::move(params));
  } catch (const SceneError& e) {
    return e.what();
  }
  return "";
}

TEST(Params, KeepDefaultsWhenNothingIsGiven) {
  const Everything e = read({});
  EXPECT_EQ(e.radius, 1.f);
  EXPECT_FALSE(e.zmin.has_value());
  EXPECT_EQ(e.mode, Mode::One);
  EXPECT_FALSE(e.window.has_value());
  EXPECT_FALSE(e.file.isGiven());
}

TEST(Params, ReadEveryKind) {
  const Everything e =
      read({floats("radius", {3}), floats("zmin", {-2}), integers("samples", {9}),
            boolean("jitter", false), string("label", "x"), string("file", "a.exr"),
            string("mode", "all"), color("tint", Rgb(1, 2, 3)), points("from", {{1, 2, 3}}),
            vectors("up", {{0, 0, 1}}), texture("sigma", "bumps"), color("Kd", Rgb(.1f)),
            floats("density", {0, 1, 2}), floats("window", {1, 2, 3, 4}), integers("index", {5, 6}),
            points("P", {{0, 0, 0}, {1, 1, 1}})});
  EXPECT_EQ(e.radius, 3.f);
  EXPECT_EQ(e.zmin, -2.f);
  EXPECT_EQ(e.samples, 9);
  EXPECT_FALSE(e.jitter);
  EXPECT_EQ(e.file.path, "dir/a.exr");
  EXPECT_EQ(e.mode, Mode::All);
  EXPECT_EQ(e.tint, Rgb(1, 2, 3));
  EXPECT_EQ(e.from.y, 2.f);
  EXPECT_EQ(e.sigma.evaluate({}), 7.f);
  EXPECT_EQ(e.Kd.constant, Rgb(.1f));
  EXPECT_EQ(e.density.size(), 3u);
  EXPECT_EQ((*e.window)[3], 4.f);
  EXPECT_THAT(e.indices, testing::ElementsAre(5, 6));
  EXPECT_EQ(e.P.size(), 2u);
}

TEST(Params, RejectWhatIsWrong) {
  EXPECT_EQ(errorOf({floats("radius", {0})}),
            "parameter \"float radius\" of 'everything' is 0, but must be greater than 0");
  EXPECT_EQ(errorOf({floats("radius", {1, 2})}),
            "parameter \"float radius\" of 'everything' has 2 values, but takes 1");
  EXPECT_EQ(
      errorOf({integers("radius", {1})}),
      "parameter \"integer radius\" of 'everything' has the wrong type: it takes \"float radius\"");
  EXPECT_EQ(errorOf({string("mode", "al")}),
            "parameter \"string mode\" of 'everything' is 'al', but must be 'all' or 'one' (did "
            "you mean 'all'?)");
  EXPECT_THAT(errorOf({floats("radius", {std::nanf("")})}), HasSubstr("is not a finite number"));
  EXPECT_THAT(errorOf({floats("density", {1, -1})}), HasSubstr("at least 0"));
  EXPECT_THAT(errorOf({integers("samples", {0})}), HasSubstr("at least 1"));
  EXPECT_THAT(errorOf({texture("sigma", "bump")}), HasSubstr("did you mean 'bumps'?"));
  EXPECT_THAT(errorOf({floats("window", {1, 2, 3})}), HasSubstr("takes 4"));
  EXPECT_THAT(errorOf({color("sigma", Rgb(1))}), HasSubstr("\"float sigma\" or \"texture sigma\""));
  EXPECT_THAT(errorOf({string("file", std::string("a\0b", 3))}), HasSubstr("zero byte"));
}

TEST(Params, TexturesComeBeforeValuesAndTheFirstSetBeforeTheSecond) {
  Lookup lookup;
  ParamSet shape = paramSet({floats("sigma", {20})}),
           material = paramSet({texture("sigma", "bumps"), color("Kd", Rgb(.9f))});
  ParamReader reader({&shape, &material}, "matte", ".", &lookup, captureLog());
  Everything e;
  e.visit(reader);
  EXPECT_EQ(e.sigma.evaluate({}),
            7.f);  // a texture of the material beats a value on the shape (PBRT-v2's order)
  EXPECT_EQ(e.Kd.constant, Rgb(.9f));
}

TEST(Params, NegativeReflectancesCountAsZeroWithAWarning) {
  ParamSet set = paramSet({color("Kd", Rgb(-.01f, .5f, .2f))});
  Log log(Log::Options{Verbosity::Normal, false, true});
  ParamReader reader({&set}, "matte", ".", nullptr, log);
  Everything e;
  e.visit(reader);
  EXPECT_EQ(e.Kd.constant, Rgb(0, .5f, .2f));
  ASSERT_EQ(log.captured().size(), 1u);
  EXPECT_THAT(log.captured()[0],
              HasSubstr("\"Kd\" has a negative component, (-0.01, 0.5, 0.2); it counts as 0"));
}

TEST(Params, UnknownOnesAreWarningsOrErrors) {
  ParamSet set = paramSet({floats("radios", {1})});
  Log log(Log::Options{Verbosity::Normal, false, true});
  reportUnusedParams(set, "sphere", Origin::PbrtV2, {"radius"}, log);
  ASSERT_EQ(log.captured().size(), 1u);
  EXPECT_EQ(log.captured()[0],
            "brume: warning: 'sphere' has no parameter \"float radios\" (did you mean 'radius'?)");
  EXPECT_THROW(reportUnusedParams(set, "pvpm", Origin::Brume, {}, log), SceneError);
  Log strict(Log::Options{Verbosity::Normal, true, true});
  EXPECT_THROW(reportUnusedParams(set, "sphere", Origin::PbrtV2, {}, strict), SceneError);
}

TEST(Params, RecorderListsDeclarationsAndValues) {
  Everything e;
  e.density.assign(20, 1.f);
  ParamRecorder recorder;
  e.visit(recorder);
  ASSERT_EQ(recorder.records.size(), 18u);
  EXPECT_EQ(recorder.records[0].type, "float");
  EXPECT_EQ(recorder.records[0].value, "1");
  EXPECT_EQ(recorder.records[0].range, "> 0");
  EXPECT_EQ(recorder.records[1].value, "");
  EXPECT_EQ(recorder.records[6].value, "\"one\"");
  EXPECT_EQ(recorder.records[12].value, "(20 values)");
  EXPECT_EQ(recorder.records[13].type, "float[4]");
  EXPECT_EQ(e.density.size(), 20u);  // visiting changes nothing
}

TEST(Errors, NearestSpelling) {
  EXPECT_EQ(nearestSpelling("homogenous", {"homogeneous", "volumegrid"}),
            " (did you mean 'homogeneous'?)");
  EXPECT_EQ(nearestSpelling("zzz", {"sphere", "cone"}), "");
  EXPECT_EQ(nearestSpelling("shpere", {"sphere", "cone"}), " (did you mean 'sphere'?)");
  EXPECT_EQ(listChoices({"a", "b", "c"}), "'a', 'b' or 'c'");
}

}  // namespace
}  // namespace brume
