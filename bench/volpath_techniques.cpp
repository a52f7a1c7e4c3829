// SPDX-License-Identifier: Apache-2.0
// What each technique of "volpath" costs and gains, and what many lights cost.
//
//   brume_volpath_techniques [SCENE ...]
//
// Small images of independent samples on one thread. Per setting:
//   us        processor time per path
//   noise     sum over pixels of the variance of a pixel (green) / sum of their squared means, of
//             one sample
//   noise*us  halves when the same noise takes half of the time
//   mean      against that of the first setting: 1 up to noise, as all are unbiased
#include <fmt/format.h>

#include <ctime>

#include "core/log.h"
#include "core/parallel.h"
#include "core/parse/scene_description.h"
#include "core/rng.h"
#include "renderers/render_job.h"

namespace {

using namespace brume;

constexpr int kPixels = 24, kSamples = 64;

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
      emission = "\"bool emissionsampling\" \"false\"", even = "\"string lights\" \"even\"";
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
      {"point-in-thick-fog",
       "LightSource \"point\" \"point from\" [0 .5 0]\n" + fog("\"color sigma_s\" [2 2 2]"),
       {on, equiangular, towards}});
  result.push_back({"point-outside",
                    "LightSource \"point\" \"point from\" [2 6 0] \"color I\" [9 9 9]\n" + kFloor +
                        fog("\"color sigma_s\" [.5 .5 .5]"),
                    {on, equiangular, towards}});
  result.push_back({"flame", flame + kFloor + fog("\"color sigma_s\" [.1 .1 .1]"), {on, emission}});
  result.push_back({"glowing-fog",
                    kFloor + fog("\"color sigma_s\" [1 1 1] \"color Le\" [1 1 1]"),
                    {on, emission}});
  result.push_back({"sky", sky + kFloor + fog("\"color sigma_s\" [1 1 1]"), {on, towards}});
  return result;
}

struct Measured {
  double us = 0, noise = 0, mean = 0;
};

Measured measure(const std::string& world, const std::string& params) {
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
  parseSceneText(text, "bench.pbrt", ".", {}, log, [&](SceneDescription description) {
    job = std::make_unique<RenderJob>(std::move(description), settings, log);
  });
  const std::clock_t start = std::clock();
  const RenderResult result = job->run(std::atomic<bool>{false}, {});
  const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;

  Measured m;
  const auto &values = result.image.channels.at("G"),
             &variances = result.image.channels.at("variance.G");
  double squares = 0, variance = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    m.mean += double{values[i]} / double(values.size());
    squares += double{values[i]} * double{values[i]};
    variance += double{variances[i]} * kSamples;
  }
  m.noise = variance / squares;
  m.us = seconds * 1e6 / (kPixels * kPixels * kSamples);
  return m;
}

}  // namespace

int main(int argc, char** argv) {
  setThreadCount(1);
  fmt::print("{:20} {:34} {:>8} {:>10} {:>10} {:>7}\n", "scene", "switched off or changed", "us",
             "noise", "noise*us", "mean");
  for (const TestScene& scene : scenes()) {
    bool wanted = argc < 2;
    for (int i = 1; i < argc; ++i) wanted |= scene.name.starts_with(argv[i]);
    if (!wanted) continue;
    double first = 0;
    for (const std::string& setting : scene.settings) {
      const Measured m = measure(scene.world, setting);
      if (first == 0) first = m.mean;
      fmt::print("{:20} {:34} {:8.2f} {:10.3g} {:10.3g} {:7.3f}\n", scene.name,
                 setting.empty() ? "-" : setting, m.us, m.noise, m.noise * m.us, m.mean / first);
      std::fflush(stdout);
    }
  }
}
