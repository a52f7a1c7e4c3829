// SPDX-License-Identifier: Apache-2.0
// Scene texts and what is built from them; spaces, names, blocks, objects, materials.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>

#include "core/parse/scene_description.h"

namespace brume {
namespace {

struct Parsed {
  std::deque<SceneDescription> frames;
  std::vector<std::string> warnings;
  std::string error;  ///< "line:column: text", empty when there is none
};

Parsed parse(const std::string& text) {
  Log log({Verbosity::Normal, false, true});
  Parsed result;
  try {
    parseSceneText(text, "t.pbrt", "", {}, log,
                   [&](SceneDescription frame) { result.frames.push_back(std::move(frame)); });
  } catch (const SceneError& e) {
    result.error = toString(e.where()) + ": " + e.what();
  }
  result.warnings = log.captured();
  return result;
}

/// The world of "<options> WorldBegin <world> WorldEnd", which must parse without a warning.
SceneDescription frameOf(const std::string& world, const std::string& options = "") {
  Parsed parsed = parse(options + "\nWorldBegin\n" + world + "\nWorldEnd");
  EXPECT_EQ(parsed.error, "");
  EXPECT_THAT(parsed.warnings, testing::IsEmpty());
  if (parsed.frames.empty()) throw SceneError("nothing parsed");
  return std::move(parsed.frames.front());
}

std::string errorOf(const std::string& world, const std::string& options = "") {
  return parse(options + "\nWorldBegin\n" + world + "\nWorldEnd").error;
}

void expectBox(const Bounds3& b, const Vec3& lo, const Vec3& hi) {
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(b.lo[i], lo[i], 1e-5f) << i;  // bounds are padded by their rounding error
    EXPECT_NEAR(b.hi[i], hi[i], 1e-5f) << i;
  }
}

const Shape& onlyShape(const SceneDescription& frame) {
  EXPECT_EQ(frame.world.shapes.size(), 1u);
  return *frame.world.shapes.front();
}

// Options ---------------------------------------------------------------------------------------

TEST(SceneBuilder, HasTheDefaultsOfPbrt) {
  const SceneDescription frame = frameOf("");
  EXPECT_EQ(frame.options.film.name, "image");
  EXPECT_EQ(frame.options.filter.name, "box");
  EXPECT_EQ(frame.options.camera.name, "perspective");
  EXPECT_EQ(frame.options.sampler.name, "lowdiscrepancy");
  EXPECT_EQ(frame.options.accelerator.name, "bvh");
  EXPECT_EQ(frame.options.renderer.name, "sampler");
  EXPECT_EQ(frame.options.surfaceIntegrator.name, "directlighting");
  EXPECT_EQ(frame.options.volumeIntegrator.name, "emission");
  EXPECT_FALSE(frame.options.globalIntegrator);
  EXPECT_FALSE(frame.options.cameraToWorld.isAnimated());
  EXPECT_EQ(frame.world.groups.size(), 1u);
}

TEST(SceneBuilder, LastOptionWinsAndPersistsOverFrames) {
  const Parsed parsed = parse(
      "Sampler \"random\" Sampler \"halton\" \"integer pixelsamples\" 7\n"
      "GlobalIntegrator \"pvpm\" \"integer photonsperpass\" [5]\n"
      "Translate 1 0 0 WorldBegin Shape \"sphere\" WorldEnd\n"
      "Film \"image\" WorldBegin WorldEnd");
  EXPECT_EQ(parsed.error, "");
  ASSERT_EQ(parsed.frames.size(), 2u);
  for (const SceneDescription& frame : parsed.frames) {
    EXPECT_EQ(frame.options.sampler.name, "halton");
    ASSERT_EQ(frame.options.sampler.params.params().size(), 1u);
    ASSERT_TRUE(frame.options.globalIntegrator);
    EXPECT_EQ(frame.options.globalIntegrator->name, "pvpm");
  }
  EXPECT_EQ(parsed.frames[0].world.shapes.size(), 1u);
  EXPECT_EQ(parsed.frames[1].world.shapes.size(), 0u);
}

TEST(SceneBuilder, DirectivesHaveTheirBlock) {
  EXPECT_EQ(parse("WorldBegin\nFilm \"image\"").error,
            "t.pbrt:2:1: Film belongs before WorldBegin (which is at t.pbrt:1:1)");
  EXPECT_EQ(parse("Shape \"sphere\"").error,
            "t.pbrt:1:1: Shape belongs between WorldBegin and WorldEnd");
  EXPECT_EQ(parse("TransformBegin").error,
            "t.pbrt:1:1: TransformBegin belongs between WorldBegin and WorldEnd");
  EXPECT_EQ(parse("").error, "t.pbrt:1:1: the file ends without WorldBegin: it describes no scene");
  EXPECT_EQ(parse("WorldBegin\n").error,
            "t.pbrt:2:1: the file ends before WorldEnd (WorldBegin is at t.pbrt:1:1)");
  EXPECT_EQ(parse("Shap \"sphere\"").error,
            "t.pbrt:1:1: there is no directive 'Shap' (did you mean 'Shape'?)");
  EXPECT_EQ(parse("Translate 1 2 3 4").error,
            "t.pbrt:1:17: a directive is expected here, not the number 4 (after Translate)");
  EXPECT_EQ(parse("Translate 1 2 x").error,
            "t.pbrt:1:15: Translate takes 3 numbers, but after 2 of them comes 'x'");
}

// Transformations -------------------------------------------------------------------------------

TEST(SceneBuilder, TransformsApplyLastFirst) {
  const SceneDescription frame = frameOf("Translate 1 2 3 Scale 2 2 2 Shape \"sphere\"");
  expectBox(onlyShape(frame).bounds(), {-1, 0, 1}, {3, 4, 5});
}

TEST(SceneBuilder, MatricesAreColumnMajor) {
  const char* matrix = "[2 0 0 0  0 2 0 0  0 0 2 0  1 2 3 1]";
  const std::string replace = std::string("Translate 9 9 9 Transform ") + matrix;
  expectBox(onlyShape(frameOf(replace + " Shape \"sphere\"")).bounds(), {-1, 0, 1}, {3, 4, 5});
  const std::string concat = std::string("Translate 10 0 0 ConcatTransform ") + matrix;
  expectBox(onlyShape(frameOf(concat + " Shape \"sphere\"")).bounds(), {9, 0, 1}, {13, 4, 5});
}

TEST(SceneBuilder, RenderSpaceIsAroundTheCamera) {
  // Far from the origin nothing of the sphere's size is lost, neither in placing nor in the origin.
  const SceneDescription frame = frameOf("Translate 1e9 0 5 Shape \"sphere\" \"float radius\" 1e-3",
                                         "LookAt 1e9 0 0  1e9 0 1  0 1 0 Camera \"perspective\"");
  EXPECT_EQ(frame.world.sceneOrigin, Vec3d(1e9, 0, 0));
  EXPECT_EQ(frame.options.cameraToWorld.start().matrix()[3], glm::dvec4(1e9, 0, 0, 1));
  const Bounds3 b = onlyShape(frame).bounds();
  EXPECT_NEAR(b.center().x, 0, 1e-6);
  EXPECT_NEAR(b.hi.x - b.lo.x, 2e-3, 1e-5);
}

TEST(SceneBuilder, NamedCoordinateSystems) {
  const SceneDescription frame = frameOf(
      "Translate 5 0 0 CoordinateSystem \"here\" Identity\n"
      "CoordSysTransform \"here\" Shape \"sphere\"\n"
      "CoordSysTransform \"camera\" Shape \"sphere\"\n"
      "CoordSysTransform \"world\" Shape \"sphere\"",
      "Translate 0 0 7 Camera \"perspective\"");
  ASSERT_EQ(frame.world.shapes.size(), 3u);
  EXPECT_EQ(frame.world.sceneOrigin, Vec3d(0, 0, -7));
  const auto centerOf = [&](std::size_t i) { return frame.world.shapes[i]->bounds().center(); };
  EXPECT_NEAR(distance(centerOf(0), Vec3(5, 0, 7)), 0, 1e-5f);
  EXPECT_NEAR(distance(centerOf(1), Vec3(0, 0, 0)), 0, 1e-5f);
  EXPECT_NEAR(distance(centerOf(2), Vec3(0, 0, 7)), 0, 1e-5f);
  EXPECT_EQ(errorOf("CoordSysTransform \"worl\""),
            "t.pbrt:3:19: there is no coordinate system 'worl' (did you mean 'world'?)");
}

TEST(SceneBuilder, BlocksRestoreWhatTheySave) {
  const SceneDescription frame = frameOf(
      "AttributeBegin Translate 4 0 0 ActiveTransform EndTime AttributeEnd Shape \"sphere\"\n"
      "TransformBegin Translate 4 0 0 Material \"mirror\" TransformEnd\n"
      "Translate 1 0 0 Shape \"sphere\"");
  ASSERT_EQ(frame.world.shapes.size(), 2u);
  EXPECT_NEAR(frame.world.shapes[0]->bounds().center().x, 0, 1e-5f);
  EXPECT_NEAR(frame.world.shapes[1]->bounds().center().x, 1, 1e-5f);
  const PrimitiveGroup& scene = frame.world.groups.back();
  EXPECT_NE(scene.primitives[0].material, scene.primitives[1].material);  // matte and mirror
}

TEST(SceneBuilder, BlocksMustMatch) {
  EXPECT_EQ(errorOf("AttributeEnd"), "t.pbrt:3:1: AttributeEnd without AttributeBegin");
  EXPECT_EQ(errorOf("AttributeBegin\nTransformEnd"),
            "t.pbrt:4:1: TransformEnd inside the block that AttributeBegin opened at t.pbrt:3:1");
  EXPECT_EQ(errorOf("TransformBegin"),
            "t.pbrt:4:1: WorldEnd comes before TransformEnd (TransformBegin is at t.pbrt:3:1)");
  EXPECT_EQ(errorOf("ObjectBegin \"a\" AttributeBegin ObjectEnd"),
            "t.pbrt:3:32: ObjectEnd inside the block that AttributeBegin opened at t.pbrt:3:17");
}

// Motion and objects ----------------------------------------------------------------------------

TEST(SceneBuilder, MovingShapesAreInstances) {
  const SceneDescription frame = frameOf(
      "Translate 1 0 0 ActiveTransform EndTime Translate 2 0 0 ActiveTransform All\n"
      "Shape \"sphere\"",
      "TransformTimes 1 3 LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\"");
  ASSERT_EQ(frame.world.groups.size(), 2u);
  ASSERT_EQ(frame.world.groups[1].instances.size(), 1u);
  EXPECT_TRUE(frame.world.groups[1].primitives.empty());
  expectBox(onlyShape(frame).bounds(), Vec3(-1), Vec3(1));  // in its object space
  const AnimatedTransform& motion = frame.world.groups[1].instances[0].groupToParent;
  EXPECT_NEAR(distance(motion.at(1).point(Vec3(0)), Vec3(1, 0, 5)), 0, 1e-6f);
  EXPECT_NEAR(distance(motion.at(2).point(Vec3(0)), Vec3(2, 0, 5)), 0, 1e-6f);
  EXPECT_NEAR(distance(motion.at(3).point(Vec3(0)), Vec3(3, 0, 5)), 0, 1e-6f);
}

TEST(SceneBuilder, MovingCameraTakesTheTimesOfTheScene) {
  const SceneDescription frame =
      frameOf("Shape \"sphere\"",
              "ActiveTransform EndTime Translate 0 0 2 ActiveTransform All Camera \"perspective\"\n"
              "TransformTimes 0 4");
  EXPECT_TRUE(frame.options.cameraToWorld.isAnimated());
  EXPECT_EQ(frame.options.cameraToWorld.endTime(), 4);
  EXPECT_EQ(frame.world.sceneOrigin, Vec3d(0));
}

/// Where instance `i` of the scene shows the centre of its group's first shape.
Vec3 instanceCenter(const SceneDescription& frame, std::size_t i, float time = 0) {
  const PrimitiveGroup& scene = frame.world.groups.back();
  const PrimitiveGroup& group = frame.world.groups.at(scene.instances.at(i).group);
  const Vec3 center = group.primitives.at(0).shape->bounds().center();
  return scene.instances[i].groupToParent.at(time).point(center);
}

TEST(SceneBuilder, ObjectsAreInstancedOnTopOfTheirDefinition) {
  const SceneDescription frame = frameOf(
      "Translate 1 0 0 ObjectBegin \"o\" Translate 0 2 0 Shape \"sphere\" Shape \"disk\" "
      "ObjectEnd\n"
      "ObjectBegin \"unused\" Shape \"sphere\" ObjectEnd\n"
      "Identity Translate 0 0 3 ObjectInstance \"o\" Translate 0 0 3 ObjectInstance \"o\"",
      "LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\"");
  ASSERT_EQ(frame.world.groups.size(), 2u) << "the unused object is dropped";
  EXPECT_EQ(frame.world.groups[0].primitives.size(), 2u);
  ASSERT_EQ(frame.world.groups[1].instances.size(), 2u);
  EXPECT_NEAR(distance(instanceCenter(frame, 0), Vec3(1, 2, 8)), 0, 1e-5f);
  EXPECT_NEAR(distance(instanceCenter(frame, 1), Vec3(1, 2, 11)), 0, 1e-5f);
}

TEST(SceneBuilder, FarObjectsKeepTheirPrecision) {
  const SceneDescription frame = frameOf(
      "Translate 1e9 0 5 ObjectBegin \"o\" Shape \"sphere\" \"float radius\" 0.01 ObjectEnd "
      "Identity ObjectInstance \"o\"",
      "LookAt 1e9 0 0  1e9 0 1  0 1 0 Camera \"perspective\"");
  EXPECT_NEAR(distance(instanceCenter(frame, 0), Vec3(0, 0, 5)), 0, 1e-4f);
  EXPECT_NEAR(frame.world.shapes[0]->bounds().diagonal().x, 0.02f, 1e-5f);
}

TEST(SceneBuilder, MovingShapesInObjectsBecomeInstancesOfTheScene) {
  const SceneDescription frame = frameOf(
      "ObjectBegin \"o\" Shape \"disk\" ActiveTransform EndTime Translate 0 1 0 Shape \"sphere\" "
      "ObjectEnd Rotate 90 0 0 1 Translate 5 0 0 ObjectInstance \"o\"");
  ASSERT_EQ(frame.world.groups.size(), 3u);
  ASSERT_EQ(frame.world.groups[2].instances.size(), 2u);
  EXPECT_NEAR(distance(instanceCenter(frame, 1, 0), Vec3(0, 5, 0)), 0, 1e-5f);
  EXPECT_NEAR(distance(instanceCenter(frame, 1, 1), Vec3(-1, 5, 0)), 0, 1e-5f);
}

TEST(SceneBuilder, ObjectsDoNotNest) {
  EXPECT_EQ(errorOf("ObjectBegin \"a\" ObjectBegin \"b\""),
            "t.pbrt:3:17: ObjectBegin inside an object: definitions do not nest");
  EXPECT_EQ(errorOf("ObjectBegin \"a\" ObjectInstance \"a\""),
            "t.pbrt:3:32: ObjectInstance inside an object: definitions do not nest");
  EXPECT_EQ(errorOf("ObjectBegin \"tree\" ObjectEnd ObjectInstance \"tre\""),
            "t.pbrt:3:45: there is no object 'tre' (did you mean 'tree'?); objects are defined "
            "between WorldBegin and WorldEnd, for this frame");
  EXPECT_EQ(errorOf("ObjectEnd"), "t.pbrt:3:1: ObjectEnd without ObjectBegin");
}

// Lights and volumes ----------------------------------------------------------------------------

TEST(SceneBuilder, AreaLightsEndWithTheirBlock) {
  const SceneDescription frame = frameOf(
      "AttributeBegin AreaLightSource \"area\" \"color L\" [2 2 2] Shape \"sphere\" Shape "
      "\"disk\"\n"
      "AreaLightSource \"\" Shape \"disk\" AttributeEnd Shape \"sphere\"");
  EXPECT_EQ(frame.world.lights.size(), 2u);
  const auto& primitives = frame.world.groups.back().primitives;
  ASSERT_EQ(primitives.size(), 4u);
  EXPECT_EQ(primitives[0].areaLight, frame.world.lights[0].get());
  EXPECT_EQ(primitives[1].areaLight, frame.world.lights[1].get());
  EXPECT_EQ(primitives[2].areaLight, nullptr);
  EXPECT_EQ(primitives[3].areaLight, nullptr);
}

TEST(SceneBuilder, AreaLightsInObjectsAreSeenButNotSampled) {
  const Parsed parsed = parse(
      "WorldBegin AreaLightSource \"area\" ObjectBegin \"o\" Shape \"sphere\" ObjectEnd "
      "ObjectInstance \"o\" ActiveTransform EndTime Translate 1 0 0 Shape \"sphere\" WorldEnd");
  ASSERT_EQ(parsed.error, "");
  ASSERT_EQ(parsed.warnings.size(), 2u);
  EXPECT_THAT(parsed.warnings[0], testing::HasSubstr("does not light the scene"));
  EXPECT_THAT(parsed.warnings[1], testing::HasSubstr("moving shape cannot be an area light"));
  const Scene::Contents& world = parsed.frames[0].world;
  EXPECT_TRUE(world.lights.empty());
  ASSERT_EQ(world.unsampledLights.size(), 1u);
  EXPECT_EQ(world.groups[world.groups.back().instances[0].group].primitives[0].areaLight,
            world.unsampledLights[0].get());
}

TEST(SceneBuilder, VolumesAndLightsAreInRenderSpace) {
  const SceneDescription frame = frameOf(
      "Translate 0 0 1 Volume \"homogeneous\" \"color sigma_s\" [1 1 1] LightSource \"point\"",
      "LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\"");
  ASSERT_EQ(frame.world.volumes.size(), 1u);
  expectBox(frame.world.volumes[0]->bounds(), {0, 0, 6}, {1, 1, 7});
  ASSERT_TRUE(frame.world.lights[0]->position());
  EXPECT_NEAR(distance(*frame.world.lights[0]->position(), Vec3(0, 0, 6)), 0, 1e-6f);
}

TEST(SceneBuilder, UnknownPluginsAreErrors) {
  EXPECT_THAT(errorOf("Shape \"spere\""),
              testing::StartsWith("t.pbrt:3:7: unknown Shape \"spere\" (did you mean 'sphere'?); "
                                  "choose 'cone', "));
  EXPECT_THAT(errorOf("Material \"subsurface\""), testing::HasSubstr("is not part of brume"));
  for (const char* directive : {"LightSource", "AreaLightSource", "Volume", "Material", "Shape"})
    EXPECT_THAT(errorOf(std::string(directive) + " \"nothing\""),
                testing::HasSubstr("unknown " + std::string(directive) + " \"nothing\""));
  EXPECT_THAT(errorOf("Texture \"t\" \"color\" \"nothing\""),
              testing::HasSubstr("unknown Texture spectrum \"nothing\""));
  EXPECT_THAT(errorOf("Texture \"t\" \"colour\" \"constant\""),
              testing::HasSubstr("3:13: 'colour' is no texture type: 'float', 'color' or "
                                 "'spectrum' (did you mean 'color'?)"));
}

// Materials and textures ------------------------------------------------------------------------

TEST(SceneBuilder, ShapesShareAMaterialTheyDoNotOverride) {
  const SceneDescription frame = frameOf(
      "Material \"matte\" \"color Kd\" [.1 .1 .1] Shape \"sphere\" Shape \"sphere\"\n"
      "AttributeBegin Shape \"disk\" AttributeEnd\n"
      "Shape \"sphere\" \"color Kd\" [1 0 0]\n"
      "Material \"matte\" Shape \"sphere\"");
  const auto& p = frame.world.groups.back().primitives;
  ASSERT_EQ(p.size(), 5u);
  EXPECT_EQ(p[0].material, p[1].material);
  EXPECT_EQ(p[0].material, p[2].material);
  EXPECT_NE(p[0].material, p[3].material);
  EXPECT_NE(p[0].material, p[4].material);
  EXPECT_EQ(frame.world.materials.size(), 3u);
}

TEST(SceneBuilder, TexturesAreMadeWhenUsed) {
  const SceneDescription frame = frameOf(
      "Texture \"a\" \"color\" \"imagemap\" \"string filename\" \"nowhere.exr\"\n"
      "Texture \"b\" \"color\" \"constant\" \"color value\" [.5 .5 .5]\n"
      "Texture \"c\" \"spectrum\" \"scale\" \"texture tex1\" \"b\"\n"
      "Material \"matte\" \"texture Kd\" \"a\"\n"
      "Material \"matte\" \"texture Kd\" \"c\" Shape \"sphere\" Shape \"sphere\"");
  EXPECT_EQ(frame.world.rgbTextures.size(), 2u);
  EXPECT_EQ(frame.world.floatTextures.size(), 0u);
  EXPECT_EQ(frame.world.materials.size(), 1u);
}

TEST(SceneBuilder, NamesMeanWhatTheyMeanWhereTheyStand) {
  // A texture's own definition, a redefinition in between, and one that ends with its block.
  const SceneDescription frame = frameOf(
      "Texture \"t\" \"color\" \"constant\" \"color value\" [1 0 0]\n"
      "Texture \"t\" \"color\" \"scale\" \"texture tex1\" \"t\" \"color tex2\" [.5 .5 .5]\n"
      "Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\"\n"
      "AttributeBegin Texture \"t\" \"color\" \"constant\" \"color value\" [0 1 0]\n"
      "Shape \"sphere\" AttributeEnd Shape \"sphere\"");
  const auto& p = frame.world.groups.back().primitives;
  ASSERT_EQ(p.size(), 3u);
  EXPECT_NE(p[0].material, p[1].material) << "the name has been redefined before the Shape";
  EXPECT_EQ(frame.world.rgbTextures.size(), 3u);
  EXPECT_EQ(errorOf("AttributeBegin Texture \"t\" \"color\" \"constant\" AttributeEnd\n"
                    "Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\""),
            "t.pbrt:4:18: parameter \"texture Kd\" of 'matte' names 't', but there is no color "
            "texture of that name");
}

TEST(SceneBuilder, NamedMaterials) {
  const SceneDescription frame = frameOf(
      "Material \"matte\" \"color Kd\" [.1 .2 .3]\n"
      "MakeNamedMaterial \"m\" \"string type\" \"plastic\"\n"  // takes Kd of the current Material
      "MakeNamedMaterial \"n\" \"string type\" \"mirror\"\n"
      "MakeNamedMaterial \"never\" \"string type\" \"mirror\"\n"
      "NamedMaterial \"m\" Shape \"sphere\" Shape \"disk\"\n"
      "AttributeBegin NamedMaterial \"n\" Shape \"sphere\" AttributeEnd Shape \"sphere\"\n"
      "Material \"mix\" \"string namedmaterial1\" \"m\" \"string namedmaterial2\" \"n\"\n"
      "Shape \"sphere\"");
  const auto& p = frame.world.groups.back().primitives;
  ASSERT_EQ(p.size(), 5u);
  EXPECT_EQ(p[0].material, p[1].material);
  EXPECT_NE(p[0].material, p[2].material);
  EXPECT_EQ(p[0].material, p[3].material);
  EXPECT_EQ(frame.world.materials.size(), 3u) << "m, n and the mix";
  EXPECT_EQ(errorOf("MakeNamedMaterial \"red\" \"string type\" \"matte\" NamedMaterial \"rad\""),
            "t.pbrt:3:61: there is no named material 'rad' (did you mean 'red'?)");
  EXPECT_EQ(errorOf("MakeNamedMaterial \"m\" \"color Kd\" [1 1 1]"),
            "t.pbrt:3:19: the named material 'm' has no \"string type\"");
}

TEST(SceneBuilder, MixesAndTexturesThatGrowWithoutLimitAreErrors) {
  std::string mixes = "MakeNamedMaterial \"m0\" \"string type\" \"matte\"\n";
  std::string textures = "Texture \"t0\" \"float\" \"constant\"\n";
  for (int i = 1; i < 40; ++i) {
    const std::string last = std::to_string(i - 1), now = std::to_string(i);
    mixes += "MakeNamedMaterial \"m" + now +
             "\" \"string type\" \"mix\" \"string namedmaterial1\" "
             "\"m" +
             last + "\" \"string namedmaterial2\" \"m" + last + "\"\n";
    textures += "Texture \"t" + now + "\" \"float\" \"scale\" \"texture tex1\" \"t" + last +
                "\" \"texture tex2\" \"t" + last + "\"\n";
  }
  EXPECT_THAT(errorOf(mixes), testing::HasSubstr("mixes more than 64 materials"));
  EXPECT_THAT(errorOf(textures), testing::HasSubstr("looks up more than 4096 others"));
}

TEST(SceneBuilder, UnusedParametersAreReportedOnce) {
  const auto warningsOf = [](const std::string& world) {
    return parse("WorldBegin\n" + world + "\nWorldEnd").warnings;
  };
  // What overrides the material is used.
  EXPECT_THAT(warningsOf("Shape \"sphere\" \"color Kd\" [1 1 1] \"float radius\" 2"),
              testing::IsEmpty());
  EXPECT_THAT(warningsOf("Shape \"sphere\" \"float radios\" 2"),
              testing::ElementsAre(testing::HasSubstr("did you mean 'radius'?")));
  EXPECT_THAT(warningsOf("Material \"matte\" \"float sigmo\" 2 Shape \"disk\" Shape \"disk\""),
              testing::ElementsAre(testing::HasSubstr("did you mean 'sigma'?")));
  EXPECT_THAT(warningsOf("Texture \"t\" \"float\" \"constant\" \"float valve\" 2"),
              testing::ElementsAre(testing::HasSubstr("did you mean 'value'?")));
  EXPECT_EQ(
      warningsOf("AreaLightSource \"area\" \"float M\" 2 Shape \"disk\" Shape \"disk\"").size(),
      1u);
  EXPECT_EQ(warningsOf("LightSource \"point\" \"float M\" 2").size(), 1u);
  EXPECT_EQ(warningsOf("Volume \"homogeneous\" \"float M\" 2").size(), 1u);
}

TEST(SceneBuilder, ParametersAreCheckedWhereTheyStandEvenWhenUnused) {
  EXPECT_THAT(errorOf("Material \"matte\" \"string Kd\" \"red\""), testing::HasSubstr("3:18: "));
  EXPECT_THAT(errorOf("Texture \"t\" \"float\" \"scale\" \"texture tex1\" \"u\""),
              testing::HasSubstr("there is no float texture of that name"));
  EXPECT_THAT(errorOf("AreaLightSource \"area\" \"integer nsamples\" [1 2]"),
              testing::HasSubstr("has 2 values, but takes 1"));
}

}  // namespace
}  // namespace brume
