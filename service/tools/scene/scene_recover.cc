// omni scene recover: the strokes that omnid has kept (scene/journal), also without omnid.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <system_error>

#include <nlohmann/json.hpp>

#include "service/config/paths.h"
#include "service/scene/glb_save.h"
#include "service/scene/journal/journal_folder.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/files.h"
#include "service/tools/common/output.h"
#include "service/tools/scene/scene.h"

namespace omni::tools {
namespace {

constexpr const char* kRecover = "omni scene recover";

struct RecoverArguments {
  std::string name, output;
  bool force = false, discard = false, as_json = false;
};

// The journal that a person means: a file, or one of the folder by its name, with or without ending.
base::Result<std::string> FindJournal(const std::string& folder, const std::string& name) {
  if (name.find('/') != std::string::npos) return name;
  for (const std::string& path : scene::JournalsIn(folder)) {
    const std::filesystem::path file(path);
    if (name == file.filename() || name == file.stem()) return path;
  }
  return base::Error{"there is no journal '" + name + "' in " + folder + "; list them by omni scene recover"};
}

nlohmann::json RowOf(const std::string& path) {
  const base::Result<scene::JournalContent> content = scene::ReadJournal(path);
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  nlohmann::json row = {{"name", std::filesystem::path(path).stem().string()},
                        {"file", path},
                        {"bytes", error ? 0 : bytes},
                        {"in_use", scene::IsJournalInUse(path)},
                        {"problem", content.ok() ? content->damage : content.error()}};
  if (!content.ok()) return row;
  row["application"] = content->head.application;
  row["scene"] = content->head.scene;
  row["object"] = content->head.object;
  row["strokes"] = content->strokes();
  row["date"] = scene::JournalTimeText(content->time_s);
  row["time_s"] = content->time_s;  // Unix time
  row["saved"] = content->saved;
  return row;
}

int List(const RecoverArguments& arguments, const std::string& folder) {
  nlohmann::json rows = nlohmann::json::array();
  for (const std::string& path : scene::JournalsIn(folder)) rows.push_back(RowOf(path));
  if (arguments.as_json) {
    PrintJson(nlohmann::json{{"folder", folder}, {"journals", rows}});
  } else {
    Print(JournalsText(folder, rows));
  }
  return kExitOk;
}

int WriteJournal(const RecoverArguments& arguments, const std::string& path) {
  const auto fail = [&](const std::string& why) { return FailWith(arguments.as_json, kRecover, why); };
  const base::Result<scene::JournalContent> content = scene::ReadJournal(path);
  if (!content.ok()) return fail(content.error());
  const base::Result<haptics::SceneInput> scene = scene::SculptedByJournal(*content);
  if (!scene.ok()) return fail(path + ": " + scene.error());
  const base::Result<std::string> glb = scene::GlbBytes(*scene);
  if (!glb.ok()) return fail(path + ": " + glb.error());
  const base::Status written = WriteWholeFile(arguments.output, *glb, arguments.force);
  if (!written.ok()) return fail(written.error());
  const std::size_t strokes = content->strokes();
  if (arguments.as_json) {
    PrintJson(nlohmann::json{{"output", arguments.output},
                             {"strokes", strokes},
                             {"triangles", scene->objects[0].triangles.size()},
                             {"problem", content->damage}});
    return kExitOk;
  }
  Print(arguments.output + ": " + content->head.object + " with " + Plural(strokes, "stroke") + ", " +
        Plural(scene->objects[0].triangles.size(), "triangle") + "\n");
  if (!content->damage.empty()) Print("The journal is " + content->damage + "; what follows there is lost.\n");
  return kExitOk;
}

int Recover(const RecoverArguments& arguments) {
  const std::string folder = config::UserSculptFolder();
  if (arguments.name.empty()) {
    if (arguments.discard || !arguments.output.empty()) {
      return FailUsage(kRecover, "--output and --discard need the name of a journal");
    }
    return List(arguments, folder);
  }
  const base::Result<std::string> path = FindJournal(folder, arguments.name);
  if (!path.ok()) return FailWith(arguments.as_json, kRecover, path.error());
  if (!arguments.output.empty()) return WriteJournal(arguments, *path);
  if (!arguments.discard) return FailUsage(kRecover, "say what to do with it: -o FILE.glb, or --discard");
  const std::vector<std::string> journals = scene::JournalsIn(folder);
  if (std::find(journals.begin(), journals.end(), *path) == journals.end()) {
    return FailWith(arguments.as_json, kRecover, *path + ": only journals in " + folder + " are discarded");
  }
  const base::Status discarded = scene::DiscardJournal(*path);
  if (!discarded.ok()) return FailWith(arguments.as_json, kRecover, discarded.error());
  if (arguments.as_json) {
    PrintJson(nlohmann::json{{"discarded", *path}});
  } else {
    Print(*path + ": discarded\n");
  }
  return kExitOk;
}

}  // namespace

std::string JournalsText(const std::string& folder, const nlohmann::json& rows) {
  if (rows.empty()) return folder + ": no strokes are kept\n";
  std::string text;
  for (const nlohmann::json& row : rows) {
    text += TextAt(row, "/name") + "\n";
    if (row.contains("object")) {
      text += "    " + TextAt(row, "/object") + " of " + TextAt(row, "/scene") + ", " + TextAt(row, "/application") +
              ": " + Plural(static_cast<std::size_t>(NumberAt(row, "/strokes")), "stroke") + ", " +
              TextAt(row, "/date") + (TrueAt(row, "/saved") ? ", saved" : ", not saved") +
              (TrueAt(row, "/in_use") ? ", in use" : "") + "\n";
    }
    if (const std::string problem = TextAt(row, "/problem"); !problem.empty()) text += "    " + problem + "\n";
  }
  return text;
}

void AddSceneRecover(Command& scene) {
  auto arguments = std::make_shared<RecoverArguments>();
  Command recover =
      scene.AddCommand("recover", "list the strokes that were kept, write them as a .glb file, or discard");
  recover.Add("name", arguments->name, "a journal of the list, or its file (default: list them all)");
  const auto output =
      recover.Add("-o,--output", arguments->output, "write its surface to this file").WritesOnly(".glb", "binary glTF");
  recover.Add("--force", arguments->force, "replace an existing file").Needs(output);
  recover.Add("--discard", arguments->discard, "remove it; the object begins as its file has it").Excludes(output);
  recover.Add("--json", arguments->as_json, "as JSON");
  recover.SetAction(arguments, Recover);
}

}  // namespace omni::tools
