// SPDX-License-Identifier: Apache-2.0
// Noise times time of the volume integrator "single": importance sampling of distances ("mis")
// against fixed steps ("march").
//
//   brume_single_vs_march [--settings SETTING ...] [--scenes NAME|FILE.pbrt ...]
//
// The integrator alone is run along rays through pixel centres, ended at the first surface, so that
// neither antialiasing nor surfaces add noise. Each pixel gets 4 samples of the low-discrepancy
// sampler, 16 times over with different seeds. Per setting:
//   us        processor time per ray, sampler included
//   noise     sum over pixels of the variance of a pixel (luminance) / sum of their squared means
//   noise*us  halves when the same noise takes half of the time (independent samples)
//   mean      luminance against that of the first setting: 1 up to noise, as both are unbiased
#include <fmt/format.h>

#include <ctime>

#include "core/camera.h"
#include "core/rng.h"
#include "renderers/overrides.h"
#include "renderers/plugin_factory.h"

namespace {

using namespace brume;

constexpr int kSamplesPerPixel = 4, kReplicates = 16;
constexpr int kPixels = 48;  // along the shorter side of the image

struct TestScene {
  std::string name, text, stepsize;
};

const char* const kHead =
    "LookAt 0 0 -6  0 0 0  0 1 0  Camera \"perspective\" \"float fov\" 40\nWorldBegin\n";

std::string homogeneous(double sigma_a, double sigma_s, double g) {
  return fmt::format(
      "Volume \"homogeneous\" \"point p0\" [-3 -3 -3] \"point p1\" [3 3 3] \"float g\" {} "
      "\"color sigma_a\" [{} {} {}] \"color sigma_s\" [{} {} {}]\n",
      g, sigma_a, sigma_a, sigma_a, sigma_s, sigma_s, sigma_s);
}

std::string smoke() {
  constexpr int n = 48;
  std::string values;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const double u = x / 8.0, v = y / 7.0, w = z / 9.0;
        const double r = length(Vec3d(x, y, z) / double(n - 1) - Vec3d(.5));
        const double d = std::sin(u + std::sin(2 * w)) + std::sin(v + std::sin(2 * u)) +
                         std::sin(w + 2 * std::sin(v)) - 6 * sqr(r);
        values += d > 0 && r < .5 ? fmt::format("{:.3f} ", d) : "0 ";
      }
  return fmt::format(
      "Volume \"volumegrid\" \"point p0\" [-2 -2 -2] \"point p1\" [2 2 2] \"integer nx\" {0} "
      "\"integer ny\" {0} \"integer nz\" {0} \"color sigma_a\" [.2 .2 .2] \"color sigma_s\" "
      "[2 2 2] \"float density\" [{1}]\n",
      n, values);
}

std::string manyLights() {
  std::string text;
  Rng rng(1);
  for (int i = 0; i < 32; ++i) {
    const float x = 5 * rng.uniform() - 2.5f, y = 5 * rng.uniform() - 2.5f;
    const float z = 5 * rng.uniform() - 2.5f, I = .2f + 3 * rng.uniform();
    text += fmt::format("LightSource \"point\" \"point from\" [{} {} {}] \"color I\" [{} {} {}]\n",
                        x, y, z, I, I, I);
  }
  return text;
}

std::vector<TestScene> ownScenes() {
  const std::string head = kHead;
  const std::string point = "LightSource \"point\" \"point from\" [.3 .2 .1] \"color I\" [1 1 1]\n";
  const std::string sphere = "Translate -.8 -.6 0 Shape \"sphere\" \"float radius\" .4\n";
  const std::string area =
      "AttributeBegin AreaLightSource \"diffuse\" \"color L\" [9 9 9]\nTranslate 0 2 1 Rotate 90 1 "
      "0 0 Shape \"disk\" \"float radius\" .5 AttributeEnd\n";
  const std::string distant =
      "LightSource \"distant\" \"point from\" [1 2 -1] \"point to\" [0 0 0]\n";
  return {
      {"point_in_fog", head + homogeneous(.02, .1, 0) + point + sphere, ".2"},
      {"32_points_in_fog", head + homogeneous(.02, .1, 0) + manyLights() + sphere, ".2"},
      {"area_light_g.8", head + homogeneous(.02, .2, .8) + area + sphere, ".2"},
      {"dense_fog", head + homogeneous(.5, 8, .3) + distant + point + sphere, ".02"},
      {"coloured_fog",
       head +
           "Volume \"homogeneous\" \"point p0\" [-3 -3 -3] \"point p1\" [3 3 3] \"color sigma_a\" "
           "[.02 .1 .8] \"color sigma_s\" [.1 .5 2]\n" +
           point + sphere,
       ".1"},
      {"smoke_point", head + smoke() + point + sphere, ".1"},
      {"smoke_distant", head + smoke() + distant, ".1"},
      {"distant_light", head + homogeneous(.02, .2, .3) + distant + sphere, ".2"},
  };
}

double seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Measure {
  double us = 0, noise = 0, mean = 0, squares = 0;
};

/// The rays of an image, ended at surfaces.
struct View {
  std::vector<Vec2i> pixels;
  std::vector<Ray> rays;
};

Measure measure(const VolumeIntegrator& integrator, const View& view, const Sampler& sampler) {
  Stats stats;
  std::vector<double> sum(view.rays.size(), 0), squares(view.rays.size(), 0);
  const double start = seconds();
  for (int replicate = 0; replicate < kReplicates; ++replicate) {
    const auto stream = sampler.makePixelSampler(static_cast<std::uint64_t>(replicate) + 1);
    RenderContext context{*stream, stats};
    for (std::size_t i = 0; i < view.rays.size(); ++i) {
      stream->startPixel(view.pixels[i]);
      double pixel = 0;
      for (int s = 0; s < kSamplesPerPixel; ++s) {
        stream->startSample(s);
        pixel += double{integrator.integrate(view.rays[i], context).Lv.luminance()};
      }
      pixel /= kSamplesPerPixel;
      sum[i] += pixel;
      squares[i] += pixel * pixel;
    }
  }
  Measure m;
  const auto n = static_cast<double>(kReplicates), rays = static_cast<double>(view.rays.size());
  m.us = 1e6 * (seconds() - start) / (n * kSamplesPerPixel * rays);
  double variance = 0;
  for (std::size_t i = 0; i < sum.size(); ++i) {
    m.mean += sum[i] / n;
    m.squares += sqr(sum[i] / n);
    variance += std::max(0.0, squares[i] / n - sqr(sum[i] / n)) * n / (n - 1);
  }
  m.noise = variance / m.squares;
  return m;
}

void measureScene(SceneDescription description, const std::string& name,
                  const std::vector<std::string>& settings, Log& log) {
  RenderOptions& options = description.options;
  PluginFactory factory(options.searchDirectory, log);
  const Transform shift = Transform::translate(-description.world.sceneOrigin);
  options.cameraToWorld = AnimatedTransform(shift * options.cameraToWorld.start());
  const auto filter = factory.make<Filter>(options.filter, {});
  Film::FactoryContext filmContext;
  filmContext.filter = filter.get();
  auto film = factory.make<Film>(options.film, filmContext);
  const Vec2i full = film->resolution();
  const int shorter = std::min(full.x, full.y);
  filmContext.resolution = Vec2i(full.x * kPixels / shorter, full.y * kPixels / shorter);
  film = factory.make<Film>(options.film, filmContext);
  Camera::FactoryContext cameraContext;
  cameraContext.cameraToWorld = options.cameraToWorld;
  cameraContext.resolution = film->resolution();
  const auto camera = factory.make<Camera>(options.camera, cameraContext);
  PluginDirective lowDiscrepancy{"lowdiscrepancy", {}};
  Sampler::FactoryContext samplerContext;
  samplerContext.pixels = film->sampleBounds();
  samplerContext.samplesPerPixel = kSamplesPerPixel;
  const auto sampler = factory.make<Sampler>(lowDiscrepancy, samplerContext);
  const Scene scene(std::move(description.world));

  View view;
  Stats stats;
  for (int y = 0; y < film->resolution().y; ++y)
    for (int x = 0; x < film->resolution().x; ++x) {
      CameraSample sample;
      sample.raster = {static_cast<float>(x) + .5f, static_cast<float>(y) + .5f};
      FootprintRay ray = camera->generateRay(sample);
      if (const auto hit = scene.intersect(ray, stats)) ray.tMax = distance(ray.o, hit->p);
      view.pixels.push_back({x, y});
      view.rays.push_back(ray);
    }

  double mean = 0;
  for (const std::string& setting : settings) {
    PluginDirective directive = parseIntegrator("single:" + setting);
    IntegratorFactoryContext context;
    context.scene = &scene;
    context.sampler = sampler.get();
    const auto integrator = factory.make<VolumeIntegrator>(directive, context);
    const Measure m = measure(*integrator, view, *sampler);
    if (mean == 0) mean = m.mean;
    fmt::print("{:<18} {:<30} {:8.2f} us {:10.3g} noise {:10.3g} noise*us  mean {:.4f}\n", name,
               setting, m.us, m.noise, m.noise * m.us, m.mean / mean);
    std::fflush(stdout);
  }
}

std::vector<std::string> defaultSettings(const std::string& stepsize) {
  const double step = std::stod(stepsize);
  return {"samples=1",
          "samples=4",
          "samples=8",
          "samples=16",
          fmt::format("method=march,stepsize={:g}", 4 * step),
          fmt::format("method=march,stepsize={:g}", step),
          fmt::format("method=march,stepsize={:g}", step / 4)};
}

}  // namespace

int main(int argc, char** argv) try {
  std::vector<std::string> settings, scenes;
  std::vector<std::string>* target = &scenes;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--settings")
      target = &settings;
    else if (argument == "--scenes")
      target = &scenes;
    else
      target->push_back(argument);
  }
  Log::Options quiet;
  quiet.verbosity = Verbosity::Quiet;
  Log log(quiet);
  const auto run = [&](const std::string& name, const std::string& stepsize) {
    return [&, name, stepsize](SceneDescription description) {
      measureScene(std::move(description), name,
                   settings.empty() ? defaultSettings(stepsize) : settings, log);
    };
  };
  for (const TestScene& scene : ownScenes())
    if (scenes.empty() || std::find(scenes.begin(), scenes.end(), scene.name) != scenes.end())
      parseSceneText(scene.text + "WorldEnd\n", scene.name, ".", {}, log,
                     run(scene.name, scene.stepsize));
  for (const std::string& file : scenes)
    if (file.ends_with(".pbrt"))
      parseSceneFile(
          file, {}, log,
          run(file.substr(file.rfind('/') + 1), file.ends_with("smoke-2.pbrt") ? ".025" : ".5"));
  return 0;
} catch (const std::exception& e) {
  fmt::print(stderr, "{}\n", e.what());
  return 1;
}
