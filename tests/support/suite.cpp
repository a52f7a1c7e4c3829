// SPDX-License-Identifier: Apache-2.0
#include "support/suite.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "support/render_text.h"

namespace brume::test {

namespace {

constexpr int kPixels = 16, kPilotSamples = 16;
/// Renders by which a method is judged whose pixels depend on each other.
constexpr int kRepeats = 16;

/// Mean of several measurements, weighted by their samples.
void accumulate(Measurement& sum, const Measurement& m) {
  const double total = static_cast<double>(sum.samples + m.samples);
  const double a = static_cast<double>(sum.samples) / total,
               b = static_cast<double>(m.samples) / total;
  for (std::size_t c = 0; c < 3; ++c) {
    Estimate& e = sum.channels[c];
    e = {a * e.mean + b * m.channels[c].mean,
         std::hypot(a * e.standardError, b * m.channels[c].standardError)};
  }
  sum.samples += m.samples;
  sum.faults += m.faults;
}

constexpr const char* kChannels[3] = {"R", "G", "B"};

/// One render, each pixel one value.
Measurement measureByPixels(const Method& method, const SuiteScene& scene, int samples,
                            std::uint64_t seed) {
  RenderSettings settings;
  settings.seed = seed;
  const RenderResult result = renderText(sceneText(method, scene, kPixels, samples), settings);
  Measurement m;
  for (std::size_t c = 0; c < 3; ++c) m.channels[c] = estimateOf(result.image, kChannels[c]);
  m.faults = faultsOf(result.stats);
  m.samples = std::int64_t{kPixels} * kPixels * samples;
  return m;
}

/// Several renders, each one value.
Measurement measureByRenders(const Method& method, const SuiteScene& scene, int samples,
                             std::uint64_t seed) {
  Measurement m;
  std::array<double, 3> sum{}, squares{};
  for (int i = 0; i < kRepeats; ++i) {
    RenderSettings settings;
    settings.seed = seed * kRepeats + static_cast<std::uint64_t>(i);
    const RenderResult result = renderText(sceneText(method, scene, 1, samples), settings);
    const Rgb mean = meanOf(result.image);
    for (int c = 0; c < 3; ++c) {
      const double v = mean[c];
      sum[static_cast<std::size_t>(c)] += v;
      squares[static_cast<std::size_t>(c)] += v * v;
    }
    m.faults += faultsOf(result.stats);
  }
  for (std::size_t c = 0; c < 3; ++c) {
    const double mean = sum[c] / kRepeats;
    const double variance = std::max(0.0, squares[c] / kRepeats - mean * mean);
    m.channels[c] = {mean, std::sqrt(variance / (kRepeats - 1))};
  }
  m.samples = std::int64_t{kRepeats} * samples;
  return m;
}

Measurement measureOnce(const Method& method, const SuiteScene& scene, int samples,
                        std::uint64_t seed) {
  return method.pixelsAreIndependent ? measureByPixels(method, scene, samples, seed)
                                     : measureByRenders(method, scene, samples, seed);
}

/// The largest standard error relative to its mean; channels without light have none.
double worstError(const Measurement& m) {
  double worst = 0;
  for (const Estimate& e : m.channels)
    if (e.standardError > 0) worst = std::max(worst, e.standardError / std::abs(e.mean));
  return worst;
}

}  // namespace

const std::vector<Method>& judgedMethods() {
  static const std::vector<Method> kMethods = {{"volpath", "GlobalIntegrator \"volpath\""}};
  return kMethods;
}

std::string sceneText(const Method& method, const SuiteScene& scene, int pixels, int samples) {
  return fmt::format(
      "LookAt {}\nCamera \"perspective\" \"float fov\" [{}]\n"
      "Film \"image\" \"integer xresolution\" [{}] \"integer yresolution\" [{}]\n"
      "PixelFilter \"box\"\nSampler \"random\" \"integer pixelsamples\" [{}]\n{}\n"
      "WorldBegin\n{}\nWorldEnd\n",
      scene.lookAt, scene.fov, pixels, pixels, samples, method.directive, scene.world);
}

std::uint64_t faultsOf(const Stats& stats) {
  return stats[Stat::NanRadiance] + stats[Stat::InfiniteRadiance] + stats[Stat::NegativeRadiance];
}

Measurement measure(const Method& method, const SuiteScene& scene, const Goal& goal) {
  constexpr int kRounds = 4;
  const std::uint64_t firstSeed = goal.seed * (kRounds + 1);
  constexpr double kReserve = 1.2;  // the pilot's variance is itself an estimate
  const Measurement pilot = measureOnce(method, scene, kPilotSamples, firstSeed);
  const std::int64_t perSample = pilot.samples / kPilotSamples;
  Measurement sum;
  const auto wanted = [&](const Measurement& m) {
    const double factor = worstError(m) / goal.relativeError;
    const double samples = kReserve * factor * factor * static_cast<double>(m.samples);
    return std::min(samples, static_cast<double>(goal.maxSamples));
  };
  double target = std::max(wanted(pilot), static_cast<double>(pilot.samples));
  for (int round = 1; round <= kRounds; ++round) {
    const double missing = (target - static_cast<double>(sum.samples)) / double(perSample);
    if (missing < 1) break;
    accumulate(sum, measureOnce(method, scene, static_cast<int>(std::ceil(missing)),
                                firstSeed + static_cast<std::uint64_t>(round)));
    if (worstError(sum) <= goal.relativeError) break;
    target = wanted(sum);
  }
  sum.faults += pilot.faults;
  return sum;
}

Demand demandOf(Form form) {
  return form == Form::Full ? Demand{0.003, 0.003, 3} : Demand{0.015, 0, 4};
}

void expectMeans(const Measurement& m, const std::array<double, 3>& expected, Form form,
                 const std::string& what) {
  // A mean of float pixels that carry no noise is off by their rounding.
  constexpr double kFloatRounding = 1e-5;
  const Demand demand = demandOf(form);
  EXPECT_EQ(m.faults, 0u) << what;
  for (std::size_t c = 0; c < 3; ++c) {
    const Estimate& e = m.channels[c];
    const double tolerance =
        std::max({demand.tolerance * expected[c], demand.maxZ * e.standardError,
                  kFloatRounding * expected[c]});
    EXPECT_LE(std::abs(e.mean - expected[c]), tolerance)
        << what << ", channel " << c << ": " << e.mean << " +- " << e.standardError << ", expected "
        << expected[c] << " (" << 100 * (e.mean / expected[c] - 1) << " %, z "
        << (e.mean - expected[c]) / e.standardError << ", " << m.samples << " samples)";
    EXPECT_LE(e.standardError, demand.maxStandardError * expected[c]) << what << ", channel " << c;
  }
}

void expectRadiance(const Method& method, const SuiteScene& scene,
                    const std::array<double, 3>& expected, Form form, const std::string& what) {
  Goal goal;
  goal.relativeError = demandOf(form).maxStandardError * 0.9;
  expectMeans(measure(method, scene, goal), expected, form, what);
}

std::string rgbText(const std::array<double, 3>& v) {
  return fmt::format("[{} {} {}]", v[0], v[1], v[2]);
}
std::string rgbText(double v) { return rgbText(gray3(v)); }

std::string sky(const std::array<double, 3>& L) {
  return fmt::format("LightSource \"infinite\" \"color L\" {}\n", rgbText(L));
}

std::string floorAt(double z, double half, double Kd) {
  return fmt::format(
      "AttributeBegin\nMaterial \"matte\" \"color Kd\" {0}\n"
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]\n"
      "  \"point P\" [-{1} -{1} {2}  {1} -{1} {2}  {1} {1} {2}  -{1} {1} {2}]\nAttributeEnd\n",
      rgbText(Kd), half, z);
}

std::string asTestName(std::string text) {
  for (char& c : text) {
    if (c == '-') c = 'm';
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  }
  return text;
}

}  // namespace brume::test
