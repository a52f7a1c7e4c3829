// SPDX-License-Identifier: Apache-2.0
// What each technique of "volpath" costs and gains, and what many lights cost.
//
//   brume_volpath_techniques [--rounds N] [SCENE ...]
//
// Small images of independent samples on one thread, all settings of all scenes in turn, N times
// (12) with other seeds: a machine that is slow for a while is so for all of them. Per setting:
//   us        processor time per path, the least of the rounds
//   noise     mean over pixels of the variance of one sample (green) / (mean^2 + (a tenth of the
//             image's mean)^2), the means of a pixel being those of all settings and rounds
//   noise*us  halves when the same noise takes half of the time
//   mean      against that of the first setting: 1 up to noise, as all are unbiased
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <numeric>

#include "core/log.h"
#include "core/parallel.h"
#include "core/parse/scene_description.h"
#include "core/rng.h"
#include "renderers/render_job.h"

namespace {

using namespace brume;

constexpr int kPixels = 24, kSamples = 64, kRounds = 12;

struct TestScene {
  std::string name, world;
  std::vector<std::string> settings;
};

std::string fog(const std::string& more) {
  return "Volume \"homogeneous\" \"point p0\" [-3 -1 -3] \"point p1\" [3 3 3] " + more + "\n";
}
const std::string kFloor =
    "Material \"matte\" Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]\n"
    "  \"point P\" [-9 -1 -9  -9 -1 9  9 -1 9  9 -1 -9]\n";

/// Point lights of different strengths at random places in a fog, of the same power together.
std::string manyLights(int count) {
  Rng rng(1);
  std::string text = kFloor + fog("\"color sigma_s\" [.3 .3 .3]");
  for (int i = 0; i < count; ++i) {
    const double I = 20.0 / count * (0.5 + rng.uniformDouble());
    text += fmt::format(
        "LightSource \"point\" \"color I\" [{0} {0} {0}] \"point from\" [{1} {2} {3}]\n", I,
        6 * rng.uniform() - 3, 3 * rng.uniform() - .8f, 6 * rng.uniform() - 3);
  }
  return text;
}

std::vector<TestScene> scenes() {
  const std::string on,
      equiangular = "\"bool equiangular\" \"false\"", towards = "\"bool towardslights\" \"false\"",
      emission = "\"bool emissionsampling\" \"false\"", even = "\"string lights\" \"even\"",
      looking = "\"string lightfoundby\" \"looking\"",
      hitting = "\"string lightfoundby\" \"hitting\"", roulette = "\"bool roulette\" \"false\"";
  const std::string sky = "LightSource \"infinite\" \"color L\" [1 1 1]\n";
  const std::string flame =
      "Volume \"homogeneous\" \"color Le\" [500 300 90] \"color sigma_a\" [1 1 1]\n"
      "  \"point p0\" [-.1 .3 -.1] \"point p1\" [.1 .6 .1]\n";
  std::vector<TestScene> result;
  for (int n : {1, 10, 100, 1000, 10000})
    result.push_back({fmt::format("lights-{}", n), manyLights(n), {on, even}});
  result.push_back(
      {"point-in-thin-fog",
       "LightSource \"point\" \"point from\" [0 .5 0]\n" + fog("\"color sigma_s\" [.2 .2 .2]"),
       {on, equiangular, towards}});
  result.push_back(
      {"point-in-haze",
       "LightSource \"point\" \"point from\" [0 .5 0]\n" + fog("\"color sigma_s\" [.01 .01 .01]"),
       {on, equiangular, towards}});
  result.push_back(
      {"small-lamp-in-haze",
       "AttributeBegin AreaLightSource \"diffuse\" \"color L\" [900 900 900] Translate 0 .5 "
       "0 Shape \"sphere\" \"float radius\" .02 AttributeEnd\n" +
           fog("\"color sigma_s\" [.05 .05 .05]"),
       {on, equiangular}});
  result.push_back(
      {"point-in-thick-fog",
       "LightSource \"point\" \"point from\" [0 .5 0]\n" + fog("\"color sigma_s\" [2 2 2]"),
       {on, equiangular, towards}});
  result.push_back({"point-outside",
                    "LightSource \"point\" \"point from\" [2 6 0] \"color I\" [9 9 9]\n" + kFloor +
                        fog("\"color sigma_s\" [.5 .5 .5]"),
                    {on, equiangular, towards}});
  const std::string spark =
      "Volume \"homogeneous\" \"color Le\" [50000 30000 9000] \"color sigma_a\" [10 10 10]\n"
      "  \"point p0\" [-.02 .3 -.02] \"point p1\" [.02 .36 .02]\n";
  result.push_back({"spark", spark + kFloor, {on, emission}});
  result.push_back(
      {"spark-in-fog", spark + kFloor + fog("\"color sigma_s\" [.1 .1 .1]"), {on, emission}});
  result.push_back({"flame", flame + kFloor + fog("\"color sigma_s\" [.1 .1 .1]"), {on, emission}});
  result.push_back({"glowing-fog",
                    kFloor + fog("\"color sigma_s\" [1 1 1] \"color Le\" [1 1 1]"),
                    {on, emission}});
  result.push_back({"sky",
                    sky + kFloor + fog("\"color sigma_s\" [1 1 1]"),
                    {on, looking, hitting, towards, roulette}});
  const auto lamp = [](const char* radius, const char* L) {
    return fmt::format(
        "AttributeBegin AreaLightSource \"diffuse\" \"color L\" [{1} {1} {1}] Translate 0 2.2 0 "
        "Rotate 90 1 0 0 Shape \"disk\" \"float radius\" {0} AttributeEnd\n",
        radius, L);
  };
  const std::string shiny =
      "AttributeBegin Material \"metal\" \"float roughness\" .01 Translate 0 .3 0 Shape \"sphere\" "
      "AttributeEnd\n";
  for (const auto& [name, radius, L] :
       {std::tuple{"lamp", ".2", "100"}, std::tuple{"ceiling", "2.5", "1"}})
    result.push_back({fmt::format("{}-in-fog", name),
                      lamp(radius, L) + kFloor + fog("\"color sigma_s\" [.5 .5 .5]"),
                      {on, looking, hitting, roulette}});
  result.push_back(
      {"ceiling-over-metal", lamp("2.5", "1") + shiny + kFloor, {on, looking, hitting}});
  result.push_back({"lamp-in-forward-fog",
                    lamp(".5", "16") + kFloor + fog("\"color sigma_s\" [1 1 1] \"float g\" .9"),
                    {on, looking, hitting}});
  result.push_back(
      {"lamp-in-smoke",
       lamp(".5", "16") + fog("\"color sigma_s\" [.7 .7 .7] \"color sigma_a\" [.7 .7 .7]"),
       {on, roulette}});
  result.push_back(
      {"lamp-in-white-fog", lamp(".5", "16") + fog("\"color sigma_s\" [4 4 4]"), {on, roulette}});
  result.push_back({"light-under-dark-floor",
                    "Material \"matte\" \"color Kd\" [.1 .1 .1] AttributeBegin " +
                        kFloor.substr(kFloor.find("Shape")) + "AttributeEnd\n" + lamp(".5", "16"),
                    {on, roulette}});
  return result;
}

/// Sums over the rounds, and for each pixel.
struct Measured {
  double us = 1e9;
  std::vector<double> means, variances;  // of one sample

  double mean() const {
    return std::accumulate(means.begin(), means.end(), 0.0) / double(means.size());
  }
};

void measure(const std::string& world, const std::string& params, int seed, int rounds,
             Measured& sum) {
  const std::string text = fmt::format(
      "LookAt 0 1 6  0 0 0  0 1 0  Camera \"perspective\" \"float fov\" 50\n"
      "Film \"image\" \"integer xresolution\" [{0}] \"integer yresolution\" [{0}]\n"
      "Sampler \"random\" \"integer pixelsamples\" [{1}] PixelFilter \"box\"\n"
      "GlobalIntegrator \"volpath\" {2}\nWorldBegin\n{3}\nWorldEnd\n",
      kPixels, kSamples, params, world);
  Log log({Verbosity::Quiet, false, false});
  std::unique_ptr<RenderJob> job;
  RenderSettings settings;
  settings.variance = true;
  settings.seed = static_cast<std::uint64_t>(seed);
  parseSceneText(text, "bench.pbrt", ".", {}, log, [&](SceneDescription description) {
    job = std::make_unique<RenderJob>(std::move(description), settings, log);
  });
  const std::clock_t start = std::clock();
  const RenderResult result = job->run(std::atomic<bool>{false}, {});
  const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;

  const auto &values = result.image.channels.at("G"),
             &variances = result.image.channels.at("variance.G");
  sum.means.resize(values.size());
  sum.variances.resize(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum.means[i] += double{values[i]} / rounds;
    sum.variances[i] += double{variances[i]} * kSamples / rounds;
  }
  sum.us = std::min(sum.us, seconds * 1e6 / (kPixels * kPixels * kSamples));
}

/// What a setting's noise is relative to the pixels' means over all settings.
double noise(const Measured& m, const std::vector<Measured>& all) {
  std::vector<double> means(m.means.size(), 0.0);
  for (const Measured& other : all)
    for (std::size_t i = 0; i < means.size(); ++i) means[i] += other.means[i] / double(all.size());
  const double least =
      0.1 * std::accumulate(means.begin(), means.end(), 0.0) / double(means.size());
  double sum = 0;
  for (std::size_t i = 0; i < means.size(); ++i)
    sum += m.variances[i] / (means[i] * means[i] + least * least);
  return sum / double(means.size());
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> wanted(argv + 1, argv + argc);
  int rounds = kRounds;
  if (wanted.size() >= 2 && wanted[0] == "--rounds") {
    rounds = std::max(1, std::atoi(wanted[1].c_str()));
    wanted.erase(wanted.begin(), wanted.begin() + 2);
  }
  setThreadCount(1);
  std::vector<TestScene> chosen = scenes();
  std::erase_if(chosen, [&](const TestScene& scene) {
    return !wanted.empty() && std::ranges::none_of(wanted, [&](const std::string& name) {
      return scene.name.starts_with(name);
    });
  });
  std::vector<std::vector<Measured>> sums(chosen.size());
  for (int round = 0; round < rounds; ++round)
    for (std::size_t s = 0; s < chosen.size(); ++s) {
      sums[s].resize(chosen[s].settings.size());
      for (std::size_t i = 0; i < sums[s].size(); ++i)
        measure(chosen[s].world, chosen[s].settings[i], round, rounds, sums[s][i]);
    }

  fmt::print("{:22} {:34} {:>8} {:>10} {:>10} {:>7}\n", "scene", "switched off or changed", "us",
             "noise", "noise*us", "mean");
  for (std::size_t s = 0; s < chosen.size(); ++s)
    for (std::size_t i = 0; i < sums[s].size(); ++i) {
      const Measured& m = sums[s][i];
      const double n = noise(m, sums[s]);
      const std::string& setting = chosen[s].settings[i];
      fmt::print("{:22} {:34} {:8.2f} {:10.3g} {:10.3g} {:7.3f}\n", chosen[s].name,
                 setting.empty() ? "-" : setting, m.us, n, n * m.us, m.mean() / sums[s][0].mean());
    }
}
