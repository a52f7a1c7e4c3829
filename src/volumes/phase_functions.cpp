// SPDX-License-Identifier: Apache-2.0
#include "volumes/phase_functions.h"

#include <fmt/format.h>

#include <array>

namespace brume {

namespace {

class IsotropicPhase final : public PhaseFunction {
 public:
  float value(const ScatteringAngle&) const override { return kInv4Pi; }
  ScatteringAngle sampleAngle(float, float u) const override { return {2.f * (1.f - u), 2.f * u}; }
  std::optional<float> henyeyGreenstein() const override { return 0.f; }
  float g() const override { return 0; }
  float peak() const override { return kInv4Pi; }
};

class RayleighPhase final : public PhaseFunction {
 public:
  float value(const ScatteringAngle& angle) const override {
    return 0.75f * kInv4Pi * (1.f + sqr(angle.cos()));
  }
  /// The cumulative distribution is (cos^3 + 3 cos + 4) / 8: Cardano's one real root.
  ScatteringAngle sampleAngle(float, float u) const override {
    const double q = 2 * (2 * double{u} - 1);
    const double a = std::cbrt(std::abs(q) + std::sqrt(q * q + 1));
    const double c = std::clamp(std::copysign(a - 1 / a, q), -1.0, 1.0);
    return {static_cast<float>(1 - c), static_cast<float>(1 + c)};
  }
  float g() const override { return 0; }
  float peak() const override { return 1.5f * kInv4Pi; }
};

class HenyeyGreensteinPhase final : public PhaseFunction {
 public:
  explicit HenyeyGreensteinPhase(float g) : g_(g) {}

  float value(const ScatteringAngle& angle) const override {
    // 1 + g^2 - 2 g cos as a sum of two terms >= 0.
    const float a = std::abs(g_);
    const float denominator =
        sqr(1.f - a) + 2.f * a * (g_ > 0 ? angle.oneMinusCos : angle.onePlusCos);
    return kInv4Pi * (1.f - a) * (1.f + a) / (denominator * std::sqrt(denominator));
  }
  /// The usual inverse, rearranged so that 1 - cos and 1 + cos are products of exact differences.
  ScatteringAngle sampleAngle(float, float u) const override {
    const double g = g_, q = 1 - g + 2 * g * u;
    return {static_cast<float>(2 * sqr((1 - g) / q) * (1 - double{u}) * (1 + g * u)),
            static_cast<float>(2 * sqr((1 + g) / q) * u * (1 - g * (1 - double{u})))};
  }
  std::optional<float> henyeyGreenstein() const override { return g_; }
  float g() const override { return g_; }
  float peak() const override {
    const float a = std::abs(g_);
    return kInv4Pi * (1.f + a) / sqr(1.f - a);
  }

 private:
  float g_;
};

class SchlickPhase final : public PhaseFunction {
 public:
  explicit SchlickPhase(float g) : k_(1.5f * g - 0.5f * g * g * g) {}

  float value(const ScatteringAngle& angle) const override {
    const float a = std::abs(k_);
    const float denominator = 1.f - a + a * (k_ > 0 ? angle.oneMinusCos : angle.onePlusCos);
    return kInv4Pi * (1.f - a) * (1.f + a) / sqr(denominator);
  }
  ScatteringAngle sampleAngle(float, float u) const override {
    const double k = k_, q = 1 - k + 2 * k * u;
    return {static_cast<float>(2 * (1 - k) * (1 - double{u}) / q),
            static_cast<float>(2 * (1 + k) * u / q)};
  }
  /// 1/k - (1 - k^2) / (2 k^2) ln((1 + k) / (1 - k)).
  float g() const override {
    const double k = k_;
    if (std::abs(k) < 1e-3) return static_cast<float>(k * (2.0 / 3 + k * k * (2.0 / 15)));
    return static_cast<float>(1 / k - (1 - k * k) / (k * k) * std::atanh(k));
  }
  float peak() const override { return kInv4Pi * (1.f + std::abs(k_)) / (1.f - std::abs(k_)); }

 private:
  float k_;
};

/// (1/2 + (n + 1)/2 ((1 + cos) / 2)^n) / (4 pi): half isotropic, half a power of the half-angle.
class MiePhase final : public PhaseFunction {
 public:
  explicit MiePhase(int n) : n_(n) {}

  float value(const ScatteringAngle& angle) const override {
    float power = sqr(sqr(sqr(0.5f * angle.onePlusCos)));
    if (n_ == 32) power = sqr(sqr(power));
    return kInv4Pi * (0.5f + 0.5f * static_cast<float>(n_ + 1) * power);
  }
  ScatteringAngle sampleAngle(float uLobe, float u) const override {
    if (uLobe < 0.5f) return {2.f * (1.f - u), 2.f * u};
    // x = (1 + cos) / 2 has the distribution x^(n + 1); the variable 1 - u lies in (0, 1].
    const float logX = std::log1p(-u) / static_cast<float>(n_ + 1);
    return {-2.f * std::expm1(logX), 2.f * std::exp(logX)};
  }
  float g() const override {
    const float n = static_cast<float>(n_);
    return 0.5f * n / (n + 2.f);
  }
  float peak() const override { return kInv4Pi * 0.5f * static_cast<float>(n_ + 2); }

 private:
  int n_;
};

class MixturePhase final : public PhaseFunction {
 public:
  MixturePhase(std::vector<std::unique_ptr<PhaseFunction>> lobes, const std::vector<float>& weights)
      : lobes_(std::move(lobes)) {
    double sum = 0;
    for (const float w : weights) sum += double{w};
    for (const float w : weights) weights_.push_back(static_cast<float>(double{w} / sum));
  }

  float value(const ScatteringAngle& angle) const override {
    float sum = 0;
    for (std::size_t i = 0; i < lobes_.size(); ++i) sum += weights_[i] * lobes_[i]->value(angle);
    return sum;
  }
  ScatteringAngle sampleAngle(float uLobe, float u) const override {
    std::size_t i = 0;
    while (i + 1 < lobes_.size() && uLobe >= weights_[i]) uLobe -= weights_[i++];
    return lobes_[i]->sampleAngle(std::min(uLobe / weights_[i], kOneMinusEpsilon), u);
  }
  float g() const override {
    float sum = 0;
    for (std::size_t i = 0; i < lobes_.size(); ++i) sum += weights_[i] * lobes_[i]->g();
    return sum;
  }
  float peak() const override {
    float sum = 0;
    for (std::size_t i = 0; i < lobes_.size(); ++i) sum += weights_[i] * lobes_[i]->peak();
    return sum;
  }

 private:
  std::vector<std::unique_ptr<PhaseFunction>> lobes_;
  std::vector<float> weights_;  // sum 1
};

const std::vector<std::string> kPhaseNames = {"isotropic", "rayleigh", "henyeygreenstein",
                                              "schlick",   "miehazy",  "miemurky"};

std::unique_ptr<PhaseFunction> makeLobe(const std::string& name, float g,
                                        const SourceLocation& where) {
  if (name == "isotropic") return makeIsotropicPhase();
  if (name == "rayleigh") return makeRayleighPhase();
  if (name == "henyeygreenstein") return makeHenyeyGreensteinPhase(g);
  if (name == "schlick") return makeSchlickPhase(g);
  if (name == "miehazy") return makeMieHazyPhase();
  if (name == "miemurky") return makeMieMurkyPhase();
  throw SceneError(where,
                   fmt::format("'{}' is no phase function{}; \"phase\" takes {}", name,
                               nearestSpelling(name, kPhaseNames), listChoices(kPhaseNames)));
}

bool takesG(const std::string& name) { return name == "henyeygreenstein" || name == "schlick"; }

}  // namespace

void PhaseParams::visit(ParamVisitor& v) {
  v(phase, "phase",
    "phase function: isotropic, rayleigh, henyeygreenstein, schlick, miehazy or miemurky; several "
    "of them make a mixture");
  v(phaseweights, "phaseweights", kPositive, Unit::None,
    "weight of each phase function of a mixture, any sum; equal when not given");
  v(g, "g", Range<float>{-.9999f, .9999f}, Unit::None,
    "mean cosine of the scattering angle, > 0 forward; in a mixture one value for each "
    "henyeygreenstein and schlick in turn, or one for all");
}

std::unique_ptr<PhaseFunction> makeIsotropicPhase() { return std::make_unique<IsotropicPhase>(); }
std::unique_ptr<PhaseFunction> makeRayleighPhase() { return std::make_unique<RayleighPhase>(); }
std::unique_ptr<PhaseFunction> makeHenyeyGreensteinPhase(float g) {
  return std::make_unique<HenyeyGreensteinPhase>(g);
}
std::unique_ptr<PhaseFunction> makeSchlickPhase(float g) {
  return std::make_unique<SchlickPhase>(g);
}
std::unique_ptr<PhaseFunction> makeMieHazyPhase() { return std::make_unique<MiePhase>(8); }
std::unique_ptr<PhaseFunction> makeMieMurkyPhase() { return std::make_unique<MiePhase>(32); }
std::unique_ptr<PhaseFunction> makeMixturePhase(std::vector<std::unique_ptr<PhaseFunction>> lobes,
                                                const std::vector<float>& weights) {
  BRUME_CHECK(!lobes.empty() && lobes.size() == weights.size());
  return std::make_unique<MixturePhase>(std::move(lobes), weights);
}

std::unique_ptr<PhaseFunction> makePhase(const PhaseParams& params, const SourceLocation& where) {
  const std::size_t count = params.phase.size();
  if (count == 0) throw SceneError(where, "\"phase\" is an empty list");
  std::size_t withG = 0;
  for (const std::string& name : params.phase) withG += takesG(name);
  if (!params.g.empty() && withG == 0)
    throw SceneError(where, "\"g\" has no effect: no phase function in \"phase\" takes it");
  if (params.g.size() > 1 && params.g.size() != withG)
    throw SceneError(where, fmt::format("\"g\" has {} values; it takes one, or one for each of the "
                                        "{} henyeygreenstein and schlick in \"phase\"",
                                        params.g.size(), withG));
  if (!params.phaseweights.empty() && params.phaseweights.size() != count)
    throw SceneError(where, fmt::format("\"phaseweights\" has {} values for {} phase functions",
                                        params.phaseweights.size(), count));

  std::vector<std::unique_ptr<PhaseFunction>> lobes;
  std::size_t nextG = 0;
  for (const std::string& name : params.phase) {
    float g = 0;
    if (takesG(name) && !params.g.empty())
      g = params.g.size() == 1 ? params.g[0] : params.g[nextG++];
    // Henyey-Greenstein with g = 0 is isotropic, and most scenes leave it at that.
    lobes.push_back(takesG(name) && g == 0 ? makeIsotropicPhase() : makeLobe(name, g, where));
  }
  if (count == 1) return std::move(lobes.front());
  std::vector<float> weights = params.phaseweights;
  if (weights.empty()) weights.assign(count, 1.f);
  return makeMixturePhase(std::move(lobes), weights);
}

}  // namespace brume
