// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/params.h"
#include "core/phase.h"

namespace brume {

/// The parameters of a volume that choose its phase function: one lobe or a mixture.
struct PhaseParams {
  std::vector<std::string> phase{"henyeygreenstein"};
  std::vector<float> phaseweights;
  std::vector<float> g;
  void visit(ParamVisitor& v);
};

std::unique_ptr<PhaseFunction> makeIsotropicPhase();
/// 3 (1 + cos^2) / (16 pi).
std::unique_ptr<PhaseFunction> makeRayleighPhase();
/// (1 - g^2) / (4 pi (1 + g^2 - 2 g cos)^1.5), |g| < 1. Source: Henyey, Greenstein 1941.
std::unique_ptr<PhaseFunction> makeHenyeyGreensteinPhase(float g);
/// (1 - k^2) / (4 pi (1 - k cos)^2) with PBRT-v2's k = 1.5 g - 0.5 g^3, whose mean cosine is near
/// g. Source: Blasi, Le Saec, Schlick 1993.
std::unique_ptr<PhaseFunction> makeSchlickPhase(float g);
/// (1/2 + 9/2 ((1 + cos) / 2)^8) / (4 pi), PBRT-v2's fit of Mie scattering in haze.
std::unique_ptr<PhaseFunction> makeMieHazyPhase();
/// (1/2 + 33/2 ((1 + cos) / 2)^32) / (4 pi), the same in murky air.
std::unique_ptr<PhaseFunction> makeMieMurkyPhase();
/// Weighted mean; weights > 0, any sum.
std::unique_ptr<PhaseFunction> makeMixturePhase(std::vector<std::unique_ptr<PhaseFunction>> lobes,
                                                const std::vector<float>& weights);

/// What the parameters ask for; throws SceneError for unknown names and wrong counts.
std::unique_ptr<PhaseFunction> makePhase(const PhaseParams& params, const SourceLocation& where);

}  // namespace brume
