// SPDX-License-Identifier: Apache-2.0
#include "core/compatibility.h"
#include "core/registry.h"

namespace brume {
namespace {

/// PBRT-v2's uniform grid. brume intersects with Embree; the parameters have no effect.
/// Test: render_job_test.
class Grid final : public AcceleratorChoice {
 public:
  struct Params {
    bool refineimmediately = false;
    void visit(ParamVisitor& v) {
      v(refineimmediately, "refineimmediately", "no effect: Embree is used");
    }
  };
  Grid(const Params&, const FactoryContext&) {}
};

const RegisterPlugin<AcceleratorChoice, Grid> kRegistration{
    "grid", Origin::PbrtV2, "understood; Embree is used whatever the scene names"};

}  // namespace
}  // namespace brume
