// SPDX-License-Identifier: Apache-2.0
#include "main/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <sstream>

#include "core/version.h"
#include "main/option_values.h"

namespace brume {
namespace {

/// Words as the user wrote them; they are read when all of them are known.
struct RenderWords {
  std::vector<std::string> scenes, integrators;
  std::string outfile, threads, crop, resolution, spp, seed, passes, time, error, stats;
  bool quick = false, quiet = false, verbose = false, check = false, plan = false, strict = false,
       variance = false, layers = false, png = false;
};

struct DiffWords {
  std::string image, reference, block, zTest, heatmap;
  std::string maxMse, maxRelMse, maxMae, minPsnr, maxFlip, maxMeanRatioError, maxBlockError;
  bool json = false;
};

struct PluginWords {
  std::string name;
  bool markdown = false;
};

struct RegressWords {
  std::string folder, output, threads;
  std::vector<std::string> scenes;
  bool update = false, quiet = false, strict = false;
};

struct BenchWords {
  std::string file, output;
  bool quiet = false;
};

CLI::Option* addValue(CLI::App& app, const char* name, std::string& value, const char* type,
                      const char* text) {
  const CLI::Validator notEmpty{
      [](std::string& word) { return word.empty() ? "the value is empty" : ""; }, ""};
  return app.add_option(name, value, text)->type_name(type)->check(notEmpty);
}

void declareRender(CLI::App& app, RenderWords& words) {
  app.add_option("SCENE", words.scenes,
                 "scene files, rendered one after another; - is standard input")
      ->type_name("");
  const auto image = [](CLI::Option* option) { option->group("Image"); };
  image(addValue(app, "-o,--outfile", words.outfile, "FILE",
                 "image to write (.exr .png .pfm .tga); default: the scene's"));
  image(addValue(app, "--resolution", words.resolution, "WxH", "size of the image in pixels"));
  image(addValue(app, "--crop", words.crop, "x0,x1,y0,y1",
                 "render this part only; fractions of the image from the top left"));
  image(app.add_flag("--variance", words.variance,
                     "also write the variance of every pixel and its sample count (EXR)"));
  image(app.add_flag("--layers", words.layers,
                     "also write the parts of the light, depth, normal, albedo and transmittance "
                     "(EXR)"));

  image(app.add_flag("--png", words.png, "also write a PNG beside the image"));

  const auto work = [](CLI::Option* option) { option->group("How much work"); };
  work(addValue(app, "--spp", words.spp, "N", "samples per pixel"));
  work(addValue(app, "--passes", words.passes, "N", "rounds over the whole image"));
  work(addValue(app, "--time", words.time, "60s|2m|1h", "render passes for so long"));
  work(addValue(app, "--error", words.error, "E",
                "render passes until the estimated relative error is below E, e.g. 0.02"));
  work(app.add_flag("--quick", words.quick, "a rough image: a quarter of the size and samples"));
  work(addValue(app, "--threads,--ncores", words.threads, "N",
                "processor threads; default: all of the machine"));
  work(addValue(app, "--seed", words.seed, "N",
                "another seed gives other noise; default 0, always the same image"));

  const auto method = [](CLI::Option* option) { option->group("Method"); };
  method(app.add_option("--integrator", words.integrators,
                        "use this surface, volume or global integrator instead of the scene's; "
                        "may be repeated")
             ->type_name("NAME[:key=value,...]")
             ->allow_extra_args(false));

  const auto report = [](CLI::Option* option) { option->group("Messages"); };
  report(app.add_flag("--check", words.check, "read and validate the scene, render nothing"));
  report(app.add_flag("--plan", words.plan,
                      "print what the scene needs and what is skipped, render nothing"));
  report(app.add_flag("--strict", words.strict, "every warning is an error"));
  report(app.add_flag("--quiet", words.quiet, "print errors only"));
  report(app.add_flag("--verbose", words.verbose, "print what is done, and statistics at the end"));
  report(addValue(app, "--stats", words.stats, "FILE.json",
                  "write counters, times and effective parameters"));
}

CLI::App* declareDiff(CLI::App& app, DiffWords& words) {
  CLI::App* diff = app.add_subcommand("diff", "Compare two images");
  diff->add_option("IMAGE", words.image, "image")->type_name("")->required();
  diff->add_option("REFERENCE", words.reference, "what it should look like")
      ->type_name("")
      ->required();
  addValue(*diff, "--block", words.block, "N", "compare means of N x N pixels; default 1");
  addValue(*diff, "--heatmap", words.heatmap, "FILE", "write the error of every pixel as an image");
  diff->add_flag("--json", words.json, "print JSON");
  const auto limit = [diff](const char* name, std::string& value, const char* text) {
    addValue(*diff, name, value, "X", text)->group("Limits (exit code 1 past one)");
  };
  limit("--max-mse", words.maxMse, "mean squared error");
  limit("--max-relmse", words.maxRelMse, "relative mean squared error");
  limit("--max-mae", words.maxMae, "mean absolute error");
  limit("--min-psnr", words.minPsnr, "peak signal-to-noise ratio [dB]");
  limit("--max-flip", words.maxFlip, "FLIP");
  limit("--max-mean-ratio-error", words.maxMeanRatioError,
        "deviation of any channel's mean ratio from 1");
  limit("--max-block-error", words.maxBlockError,
        "relative difference that 95 % of the blocks must not exceed");
  limit("--z-test", words.zTest,
        "fail when any pixel differs at this significance for the whole image (variance layers)");
  return diff;
}

CLI::App* declarePlugins(CLI::App& app, PluginWords& words) {
  CLI::App* plugins = app.add_subcommand("plugins", "List plugins and their parameters");
  plugins->add_option("NAME", words.name, "one plugin, or one kind such as Shape")->type_name("");
  plugins->add_flag("--markdown", words.markdown, "print docs/plugins.md");
  return plugins;
}

CLI::App* declarePhotons(CLI::App& app, PhotonReportOptions& options) {
  CLI::App* photons = app.add_subcommand("photons", "Show what is in a photon file");
  photons->add_option("FILE", options.file, "file that \"savephotons\" wrote")
      ->type_name("")
      ->required();
  addValue(*photons, "--ply", options.ply, "OUT.ply", "also write the photons as a point cloud");
  return photons;
}

CLI::App* declareRegress(CLI::App& app, RegressWords& words) {
  CLI::App* regress =
      app.add_subcommand("regress", "Render the scenes of a folder and compare with references");
  regress->add_option("DIR", words.folder, "folder with NAME.pbrt and NAME.ref.exr")
      ->type_name("")
      ->required();
  regress->add_option("NAME", words.scenes, "only these scenes")->type_name("");
  regress->add_flag("--update", words.update, "render the references anew instead of comparing");
  addValue(*regress, "-o,--output", words.output, "DIR",
           "folder for images and a page of what failed; default regress-failures");
  addValue(*regress, "--threads", words.threads, "N", "processor threads; default: all");
  regress->add_flag("--strict", words.strict, "every warning is an error");
  regress->add_flag("--quiet", words.quiet, "print failures only");
  return regress;
}

CLI::App* declareBench(CLI::App& app, BenchWords& words) {
  CLI::App* bench = app.add_subcommand(
      "bench", "Render scenes by several methods and plot their error against time");
  bench->add_option("FILE", words.file, "what to measure (JSON)")->type_name("")->required();
  addValue(*bench, "-o,--output", words.output, "DIR",
           "folder for images, results.json and index.html; default: FILE-results");
  bench->add_flag("--quiet", words.quiet, "print errors only");
  return bench;
}

/// What `read` makes of an option, when it was given.
template <class Read>
auto given(const char* name, const std::string& value, Read read)
    -> std::optional<decltype(read(WrittenOption{}))> {
  if (value.empty()) return std::nullopt;
  return read(WrittenOption{name, value});
}

/// A count that an int holds.
int parseCount(const WrittenOption& option) {
  return static_cast<int>(parseWhole(option, 1, 1 << 30));
}

/// A scene that is no file and looks like a command is most likely a command of another version, or
/// misspelt.
void checkSceneWords(const std::vector<std::string>& scenes,
                     const std::vector<std::string>& commands) {
  for (const std::string& scene : scenes) {
    const bool looksLikeCommand = scene.find_first_of("./\\-") == std::string::npos;
    std::error_code ignored;
    const bool isFile =
        std::filesystem::exists(scene, ignored) && !std::filesystem::is_directory(scene, ignored);
    if (looksLikeCommand && !isFile)
      throw SceneError(fmt::format(
          "'{}' is neither a scene file nor a command of this brume{}; the commands are {}", scene,
          nearestSpelling(scene, commands), listChoices(commands)));
  }
}

int readThreads(const std::string& word) {
  const auto read = [](const WrittenOption& o) { return static_cast<int>(parseWhole(o, 1, 4096)); };
  return given("--threads", word, read).value_or(0);
}

RenderCommand readRender(const RenderWords& words) {
  if (words.scenes.empty()) throw SceneError("no scene file given; see brume --help");
  if (words.quiet && words.verbose) throw SceneError("--quiet and --verbose exclude each other");
  if (words.check && words.plan) throw SceneError("--check and --plan exclude each other");
  RenderCommand command;
  command.scenes = words.scenes;
  RenderSettings& settings = command.settings;
  settings.outputName = words.outfile;
  settings.quick = words.quick;
  settings.variance = words.variance;
  settings.layers = words.layers;
  settings.integrators = words.integrators;
  settings.seed = given("--seed", words.seed, parseSeed).value_or(0);
  settings.resolution = given("--resolution", words.resolution, parseResolution);
  settings.crop = given("--crop", words.crop, parseCrop);
  settings.samplesPerPixel = given("--spp", words.spp, parseCount);
  settings.passes = given("--passes", words.passes, parseCount);
  settings.maxSeconds = given("--time", words.time, parseDuration);
  const auto positive = [](const WrittenOption& o) { return parseNumber(o, Zero::Refused); };
  settings.targetError = given("--error", words.error, positive);

  if (words.check) command.action = RenderCommand::Action::Check;
  if (words.plan) command.action = RenderCommand::Action::Plan;
  if (words.quiet) command.log.verbosity = Verbosity::Quiet;
  if (words.verbose) command.log.verbosity = Verbosity::Verbose;
  command.log.strict = words.strict;
  command.threads = readThreads(words.threads);
  command.pngToo = words.png;
  command.statsFile = words.stats;
  return command;
}

DiffOptions readDiff(const DiffWords& words) {
  const auto limit = [](const WrittenOption& o) { return parseNumber(o, Zero::Allowed); };
  const auto significance = [](const WrittenOption& o) {
    const double p = parseNumber(o, Zero::Refused);
    if (p >= 1) throw SceneError("--z-test wants a significance level below 1, such as 0.01");
    return p;
  };
  DiffOptions options;
  options.image = words.image;
  options.reference = words.reference;
  options.block = given("--block", words.block, parseCount).value_or(1);
  options.maxMse = given("--max-mse", words.maxMse, limit);
  options.maxRelMse = given("--max-relmse", words.maxRelMse, limit);
  options.maxMae = given("--max-mae", words.maxMae, limit);
  options.minPsnr = given("--min-psnr", words.minPsnr, limit);
  options.maxFlip = given("--max-flip", words.maxFlip, limit);
  options.maxMeanRatioError = given("--max-mean-ratio-error", words.maxMeanRatioError, limit);
  options.maxBlockError = given("--max-block-error", words.maxBlockError, limit);
  options.zTest = given("--z-test", words.zTest, significance);
  options.heatmap = words.heatmap;
  options.json = words.json;
  return options;
}

RegressCommand readRegress(const RegressWords& words) {
  RegressCommand command;
  command.options.folder = words.folder;
  command.options.scenes = words.scenes;
  command.options.update = words.update;
  if (!words.output.empty()) command.options.output = words.output;
  command.threads = readThreads(words.threads);
  command.log.strict = words.strict;
  if (words.quiet) command.log.verbosity = Verbosity::Quiet;
  return command;
}

/// The first word that no declaration takes, with the nearest option of that (sub)command.
[[noreturn]] void failOnExtra(const CLI::App& app, const std::string& word) {
  if (word.empty() || word[0] != '-')
    throw SceneError(fmt::format("'{}' is one word too many; see brume {} --help", word,
                                 app.get_parent() ? app.get_name() : ""));
  std::vector<std::string> choices;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) choices.push_back("--" + name);
  const std::string name = word.substr(0, word.find('='));
  throw SceneError(
      fmt::format("unknown option '{}'{}; see brume --help", name, nearestSpelling(name, choices)));
}

const char* const kExitCodes =
    "Exit codes: 0 done, 1 something in the scene or the options is wrong (or a limit of diff is "
    "passed),\n2 brume itself failed, 129, 130 and 143 interrupted (what was rendered is written).";

}  // namespace

Command parseCommandLine(int argc, const char* const* argv) {
  CLI::App app{"brume renders PBRT scenes with fog, smoke, fire and water.", "brume"};
  app.footer(kExitCodes);
  app.set_version_flag("--version", fmt::format("brume {}", version()));
  app.allow_extras();  // reported here, with the nearest spelling
  RenderWords render;
  DiffWords compare;
  PluginWords manual;
  PhotonReportOptions photonReport;
  RegressWords regression;
  BenchWords measurement;
  declareRender(app, render);
  const CLI::App* diff = declareDiff(app, compare);
  const CLI::App* plugins = declarePlugins(app, manual);
  const CLI::App* photons = declarePhotons(app, photonReport);
  const CLI::App* regress = declareRegress(app, regression);
  const CLI::App* bench = declareBench(app, measurement);
  const std::vector<const CLI::App*> commands{diff, plugins, photons, regress, bench};

  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& request) {
    std::ostringstream text;
    app.exit(request, text, text);
    return ShowText{text.str()};
  } catch (const CLI::ParseError& error) {
    throw SceneError(fmt::format("{}; see brume --help", error.what()));
  }
  const auto checkExtras = [](const CLI::App& part) {
    if (const auto extras = part.remaining(); !extras.empty()) failOnExtra(part, extras.front());
  };
  checkExtras(app);
  for (const CLI::App* command : commands) checkExtras(*command);
  for (const CLI::App* command : commands)
    if (command->parsed())
      for (const CLI::Option* option : app.get_options())
        if (option->count() != 0)
          throw SceneError(fmt::format("{} does not go with the command '{}'", option->get_name(),
                                       command->get_name()));
  if (diff->parsed()) return readDiff(compare);
  if (plugins->parsed()) return PluginManualOptions{manual.name, manual.markdown};
  if (photons->parsed()) return photonReport;
  if (regress->parsed()) return readRegress(regression);
  if (bench->parsed())
    return BenchCommand{{measurement.file, measurement.output}, measurement.quiet};
  std::vector<std::string> names;
  for (const CLI::App* command : commands) names.push_back(command->get_name());
  checkSceneWords(render.scenes, names);
  return readRender(render);
}

}  // namespace brume
