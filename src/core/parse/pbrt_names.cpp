// SPDX-License-Identifier: Apache-2.0
#include "core/parse/pbrt_names.h"

#include <fmt/format.h>

namespace brume {

namespace {

struct Absent {
  std::string_view kind, name, advice;
};
constexpr Absent kAbsent[] = {
    {"Material", "subsurface", "use 'translucent', or 'glass' around a Volume"},
    {"Material", "kdsubsurface", "use 'translucent', or 'glass' around a Volume"},
    {"SurfaceIntegrator", "photonmap", "use 'path'"},
    {"SurfaceIntegrator", "exphotonmap", "use 'path'"},
    {"SurfaceIntegrator", "irradiancecache", "use 'path'"},
    {"SurfaceIntegrator", "igi", "use 'path'"},
    {"SurfaceIntegrator", "dipolesubsurface", "use 'path'"},
    {"SurfaceIntegrator", "diffuseprt", "use 'path' or 'directlighting'"},
    {"SurfaceIntegrator", "glossyprt", "use 'path' or 'directlighting'"},
    {"SurfaceIntegrator", "useprobes", "use 'path'"},
    {"Renderer", "metropolis", "use Renderer 'sampler' with SurfaceIntegrator 'path'"},
    {"Renderer", "createprobes", "use Renderer 'sampler' with SurfaceIntegrator 'path'"},
    {"Renderer", "surfacepoints", "use Renderer 'sampler'"},
    {"Renderer", "aggregatetest", "use Renderer 'sampler'"},
};

struct BvhParams {
  enum class Split { Sah, Middle, Equal } split = Split::Sah;
  int maxPrimitives = 4;
  void visit(ParamVisitor& v) {
    v(split, "splitmethod",
      {{"sah", Split::Sah}, {"middle", Split::Middle}, {"equal", Split::Equal}}, "not used");
    v(maxPrimitives, "maxnodeprims", kAnyInt, Unit::None, "not used");
  }
};

struct GridParams {
  bool refineImmediately = false;
  void visit(ParamVisitor& v) { v(refineImmediately, "refineimmediately", "not used"); }
};

struct KdTreeParams {
  int intersectCost = 80, traversalCost = 1, maxPrimitives = 1, maxDepth = -1;
  float emptyBonus = 0.5f;
  void visit(ParamVisitor& v) {
    v(intersectCost, "intersectcost", kAnyInt, Unit::None, "not used");
    v(traversalCost, "traversalcost", kAnyInt, Unit::None, "not used");
    v(emptyBonus, "emptybonus", kAnyFloat, Unit::None, "not used");
    v(maxPrimitives, "maxprims", kAnyInt, Unit::None, "not used");
    v(maxDepth, "maxdepth", kAnyInt, Unit::None, "not used");
  }
};

template <class Params>
void checkParams(ParamSet& set, const std::string& name, Log& log) {
  ParamReader reader({&set}, name, {}, nullptr, log);
  Params params;
  params.visit(reader);
  reportUnusedParams(set, name, Origin::PbrtV2, reader.declared(), log);
}

}  // namespace

std::string_view canonicalName(std::string_view kind, std::string_view name) {
  if (kind == "AreaLightSource" && name == "area") return "diffuse";
  if (kind == "LightSource" && name == "exinfinite") return "infinite";
  return name;
}

std::string_view adviceForAbsent(std::string_view kind, std::string_view name) {
  for (const Absent& absent : kAbsent)
    if (absent.kind == kind && absent.name == name) return absent.advice;
  return {};
}

std::string unknownPlugin(std::string_view kind, std::string_view name,
                          const std::vector<std::string>& choices) {
  if (const std::string_view advice = adviceForAbsent(kind, name); !advice.empty())
    return fmt::format("brume does not have PBRT-v2's {} {}: {}", kind, quote(name), advice);
  return fmt::format("there is no {} {}{}; there are {}", kind, quote(name),
                     nearestSpelling(name, choices), listChoices(choices));
}

void checkAccelerator(const std::string& name, ParamSet& params, Log& log) {
  if (name == "bvh")
    checkParams<BvhParams>(params, name, log);
  else if (name == "grid")
    checkParams<GridParams>(params, name, log);
  else if (name == "kdtree")
    checkParams<KdTreeParams>(params, name, log);
  else
    throw SceneError(params.where(), unknownPlugin("Accelerator", name, {"bvh", "grid", "kdtree"}));
  log.verboseOnce(fmt::format(
      "Accelerator \"{}\": Embree's is used for all scenes; the parameters have no effect", name));
}

}  // namespace brume
