// SPDX-License-Identifier: Apache-2.0
#include "renderers/overrides.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/log.h"

namespace brume {
namespace {

using testing::HasSubstr;

Log::Options captured() {
  Log::Options options;
  options.capture = true;
  return options;
}

std::string errorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const SceneError& e) {
    return e.what();
  }
  return "no error";
}

TEST(Overrides, IntegratorWithParameters) {
  PluginDirective d = parseIntegrator("path:maxdepth=12");
  EXPECT_EQ(d.name, "path");
  ASSERT_NE(d.params.find(ParamType::Integer, "maxdepth"), nullptr);
  EXPECT_EQ(std::get<std::vector<int>>(d.params.find(ParamType::Integer, "maxdepth")->values),
            std::vector<int>{12});

  d = parseIntegrator("directlighting:strategy=one,maxdepth=3");
  ASSERT_NE(d.params.find(ParamType::String, "strategy"), nullptr);
  EXPECT_EQ(
      std::get<std::vector<std::string>>(d.params.find(ParamType::String, "strategy")->values),
      std::vector<std::string>{"one"});
  d = parseIntegrator("ambientocclusion:maxdist=2.5");
  ASSERT_NE(d.params.find(ParamType::Float, "maxdist"), nullptr);
}

TEST(Overrides, MalformedIntegratorsAreErrors) {
  EXPECT_THAT(errorOf([] { parseIntegrator("pth"); }), HasSubstr("did you mean 'path'?"));
  EXPECT_THAT(errorOf([] { parseIntegrator(""); }), HasSubstr("there is no integrator ''"));
  EXPECT_THAT(errorOf([] { parseIntegrator("path:maxdept=3"); }),
              HasSubstr("did you mean 'maxdepth'?"));
  EXPECT_THAT(errorOf([] { parseIntegrator("path:maxdepth"); }), HasSubstr("has no value"));
  EXPECT_THAT(errorOf([] { parseIntegrator("path:maxdepth=1.5"); }), HasSubstr("is not a number"));
  EXPECT_THAT(errorOf([] { parseIntegrator("path:maxdepth=x"); }), HasSubstr("is not a number"));
  EXPECT_THAT(errorOf([] { parseIntegrator("igi"); }),
              HasSubstr("\"igi\" is not part of brume; use SurfaceIntegrator \"path\""));
}

TEST(Overrides, SurfaceIntegratorReplacesTheScenesGlobalOne) {
  Log log(captured());
  RenderOptions options;
  options.globalIntegrator = PluginDirective{"anything", {}};
  overrideIntegrators({"whitted"}, options, log);
  EXPECT_FALSE(options.globalIntegrator.has_value());
  EXPECT_EQ(options.surfaceIntegrator.name, "whitted");
  EXPECT_EQ(options.volumeIntegrator.name, "emission");
}

TEST(Overrides, UnbuiltPluginsAreRefusedUnlessReplaced) {
  Log log(captured());
  for (const char* name :
       {"igi", "irradiancecache", "dipolesubsurface", "diffuseprt", "glossyprt", "useprobes"}) {
    RenderOptions options;
    options.surfaceIntegrator.name = name;
    EXPECT_THAT(errorOf([&] { refuseUnbuilt(options, false, log); }),
                HasSubstr("use SurfaceIntegrator \"path\""))
        << name;
  }
  for (const char* name : {"metropolis", "createprobes", "surfacepoints", "aggregatetest"}) {
    RenderOptions options;
    options.renderer.name = name;
    EXPECT_THAT(errorOf([&] { refuseUnbuilt(options, false, log); }),
                HasSubstr("is not part of brume"))
        << name;
    refuseUnbuilt(options, true, log);
    EXPECT_EQ(options.renderer.name, "sampler");
  }
  EXPECT_EQ(log.warningCount(), 4);
}

}  // namespace
}  // namespace brume
