// SPDX-License-Identifier: Apache-2.0
#include "support/bsdf_checks.h"

#include "core/rng.h"

namespace brume::test {

SurfaceInteraction planePoint() {
  SurfaceInteraction at;
  const Frame frame = Frame::fromZ(normalize(Vec3(1, -2, 3)));
  at.n = at.ns = frame.z;
  at.shading.dpdu = at.geometry.dpdu = frame.x * 3.f;
  at.shading.dpdv = at.geometry.dpdv = frame.y * 0.5f;
  return at;
}

Vec3 fromPlane(const Vec3& w) { return Frame::fromZ(normalize(Vec3(1, -2, 3))).fromLocal(w); }

Vec3 localDirection(float cosine, float phi) {
  const float sine = safeSqrt(1 - cosine * cosine);
  return {sine * std::cos(phi), sine * std::sin(phi), cosine};
}

Rgb integrateF(const Bsdf& bsdf, const Vec3& wo, int n) {
  double sum[3] = {0, 0, 0};
  for (int i = 0; i < 2 * n; ++i)
    for (int j = 0; j < 2 * n; ++j) {
      const float cosine = -1 + (static_cast<float>(i) + .5f) / static_cast<float>(n);
      const float phi = (static_cast<float>(j) + .5f) * kPi / static_cast<float>(n);
      const Rgb f = bsdf.f(wo, bsdf.frame().fromLocal(localDirection(cosine, phi)));
      for (int c = 0; c < 3; ++c) sum[c] += f[c] * std::abs(cosine);
    }
  const double cell = 3.14159265358979 / (static_cast<double>(n) * n);
  return {static_cast<float>(sum[0] * cell), static_cast<float>(sum[1] * cell),
          static_cast<float>(sum[2] * cell)};
}

namespace {

constexpr int kBinsCos = 24, kBinsPhi = 32, kSubdivisions = 8;

int binOf(const Vec3& w) {
  const int i = std::clamp(static_cast<int>((w.z + 1) * .5f * kBinsCos), 0, kBinsCos - 1);
  const float phi = std::atan2(w.y, w.x) / (2 * kPi);
  const int j = std::clamp(static_cast<int>((phi < 0 ? phi + 1 : phi) * kBinsPhi), 0, kBinsPhi - 1);
  return i * kBinsPhi + j;
}

/// The probability of each bin; the last is that of no sample.
std::vector<double> expectedProbabilities(const Bsdf& bsdf, const Vec3& wo) {
  std::vector<double> p(kBinsCos * kBinsPhi + 1, 0.0);
  double total = 0;
  const int rows = kBinsCos * kSubdivisions, columns = kBinsPhi * kSubdivisions;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      const float cosine = -1 + 2 * (static_cast<float>(i) + .5f) / static_cast<float>(rows);
      const float phi = 2 * kPi * (static_cast<float>(j) + .5f) / static_cast<float>(columns);
      const Vec3 wi = bsdf.frame().fromLocal(localDirection(cosine, phi));
      const double v = bsdf.pdf(wo, wi, kNonSpecular) * 4.0 * 3.14159265358979 / (rows * columns);
      p[static_cast<std::size_t>((i / kSubdivisions) * kBinsPhi + j / kSubdivisions)] += v;
      total += v;
    }
  p.back() = std::max(0.0, 1 - total);
  return p;
}

/// P(X > chi2) for a chi-square variable, by the cube-root transform (Wilson, Hilferty 1931).
double pValue(double chi2, double degrees) {
  const double v = 2 / (9 * degrees);
  const double z = (std::cbrt(chi2 / degrees) - (1 - v)) / std::sqrt(v);
  return .5 * std::erfc(z / std::sqrt(2.0));
}

}  // namespace

double chiSquareOfSampling(const Bsdf& bsdf, const Vec3& wo, int samples) {
  std::vector<double> counts(kBinsCos * kBinsPhi + 1, 0.0);
  Rng rng(17);
  for (int i = 0; i < samples; ++i) {
    const float uLobe = rng.uniform();
    const auto s = bsdf.sample(wo, uLobe, rng.uniform2(), kNonSpecular);
    counts[s ? static_cast<std::size_t>(binOf(bsdf.frame().toLocal(s->wi))) : counts.size() - 1]++;
  }
  // Bins with few expected samples are pooled: the statistic needs about five in each.
  const std::vector<double> expected = expectedProbabilities(bsdf, wo);
  double chi2 = 0, pooledExpected = 0, pooledCount = 0;
  int degrees = -1;
  const auto addBin = [&](double e, double n) {
    chi2 += sqr(n - e) / e;
    ++degrees;
  };
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double e = expected[i] * samples;
    if (e >= 5) {
      addBin(e, counts[i]);
    } else {
      pooledExpected += e;
      pooledCount += counts[i];
    }
  }
  if (pooledExpected >= 5) addBin(pooledExpected, pooledCount);
  // Samples where almost none are expected: a Poisson bound of six sigma.
  if (pooledExpected < 5 && pooledCount > pooledExpected + 6 * std::sqrt(pooledExpected) + 6)
    return 0;
  return degrees > 0 ? pValue(chi2, degrees) : 1;
}

Estimate estimateAlbedo(const Bsdf& bsdf, const Vec3& wo, LobeFlags accepted, int samples) {
  Estimate e;
  Rng rng(23);
  for (int i = 0; i < samples; ++i) {
    const float uLobe = rng.uniform();
    const auto s = bsdf.sample(wo, uLobe, rng.uniform2(), accepted);
    if (!s) continue;
    const Rgb w = s->f * (absDot(s->wi, bsdf.shadingNormal()) / s->pdf);
    for (int c = 0; c < 3; ++c) {
      e.mean[c] += w[c];
      e.error[c] += sqr(static_cast<double>(w[c]));
    }
  }
  for (int c = 0; c < 3; ++c) {
    e.mean[c] /= samples;
    e.error[c] = std::sqrt(std::max(0.0, e.error[c] / samples - sqr(e.mean[c])) / samples);
  }
  return e;
}

}  // namespace brume::test
