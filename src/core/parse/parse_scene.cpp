// SPDX-License-Identifier: Apache-2.0
// The entry points of the scene language.
#include <fmt/format.h>

#include <filesystem>

#include "core/parse/parser.h"
#include "core/parse/scene_description.h"

namespace brume {

namespace {

void parse(SourceFile file, const std::string& searchDirectory, const ParseSettings& settings,
           Log& log, const Parser::OnFrame& onFrame) {
  int frames = 0;
  const Parser::OnFrame countFrame = [&](SceneDescription frame) {
    ++frames;
    onFrame(std::move(frame));
  };
  SceneBuilder builder(searchDirectory, settings, log);
  TokenStream tokens(std::move(file), searchDirectory);
  const SourceLocation end = Parser(tokens, builder, log, countFrame).run();
  if (builder.isInWorld())
    throw SceneError(end, fmt::format("the file ends before WorldEnd (WorldBegin is at {})",
                                      toString(builder.worldBeganAt())));
  if (frames == 0) throw SceneError(end, "the file ends without WorldBegin: it describes no scene");
}

}  // namespace

void parseSceneFile(const std::string& path, const ParseSettings& settings, Log& log,
                    const std::function<void(SceneDescription)>& onFrame) {
  if (path == "-") {
    parse(SourceFile(InputFile::standardInput(), internFileName("<stdin>")), "", settings, log,
          onFrame);
    return;
  }
  InputFile bytes = InputFile::open(path, InputFile::Accept::Streams, SourceLocation{});
  parse(SourceFile(std::move(bytes), internFileName(path)),
        std::filesystem::path(path).parent_path().string(), settings, log, onFrame);
}

void parseSceneText(std::string_view text, const std::string& name,
                    const std::string& searchDirectory, const ParseSettings& settings, Log& log,
                    const std::function<void(SceneDescription)>& onFrame) {
  parse(SourceFile(InputFile::borrow(text), internFileName(name)), searchDirectory, settings, log,
        onFrame);
}

}  // namespace brume
