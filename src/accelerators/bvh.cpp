// SPDX-License-Identifier: Apache-2.0
#include "core/compatibility.h"
#include "core/registry.h"

namespace brume {
namespace {

/// PBRT-v2's default accelerator. brume intersects with Embree; the parameters have no effect.
/// Test: render_job_test.
class Bvh final : public AcceleratorChoice {
 public:
  struct Params {
    enum class Split { Sah, Middle, Equal } splitmethod = Split::Sah;
    int maxnodeprims = 4;
    void visit(ParamVisitor& v) {
      v(splitmethod, "splitmethod",
        {{"sah", Split::Sah}, {"middle", Split::Middle}, {"equal", Split::Equal}},
        "no effect: Embree is used");
      v(maxnodeprims, "maxnodeprims", kPositiveInt, Unit::None, "no effect: Embree is used");
    }
  };
  Bvh(const Params&, const FactoryContext&) {}
};

const RegisterPlugin<AcceleratorChoice, Bvh> kRegistration{
    "bvh", Origin::PbrtV2, "understood; Embree is used whatever the scene names"};

}  // namespace
}  // namespace brume
