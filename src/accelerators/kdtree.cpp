// SPDX-License-Identifier: Apache-2.0
#include "core/compatibility.h"
#include "core/registry.h"

namespace brume {
namespace {

/// PBRT-v2's kd-tree. brume intersects with Embree; the parameters have no effect.
/// Test: render_job_test.
class KdTree final : public AcceleratorChoice {
 public:
  struct Params {
    int intersectcost = 80, traversalcost = 1, maxprims = 1, maxdepth = -1;
    float emptybonus = 0.5f;
    void visit(ParamVisitor& v) {
      constexpr std::string_view kText = "no effect: Embree is used";
      v(intersectcost, "intersectcost", kAnyInt, Unit::None, kText);
      v(traversalcost, "traversalcost", kAnyInt, Unit::None, kText);
      v(emptybonus, "emptybonus", kAnyFloat, Unit::None, kText);
      v(maxprims, "maxprims", kAnyInt, Unit::None, kText);
      v(maxdepth, "maxdepth", kAnyInt, Unit::None, kText);
    }
  };
  KdTree(const Params&, const FactoryContext&) {}
};

const RegisterPlugin<AcceleratorChoice, KdTree> kRegistration{
    "kdtree", Origin::PbrtV2, "understood; Embree is used whatever the scene names"};

}  // namespace
}  // namespace brume
