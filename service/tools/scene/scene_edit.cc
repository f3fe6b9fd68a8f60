#include "service/tools/scene/scene.h"

#include <cstdio>
#include <iostream>
#include <memory>

#include <nlohmann/json.hpp>

#include "service/tools/common/command_line.h"
#include "service/tools/common/files.h"
#include "service/tools/common/output.h"
#include "service/tools/common/service_link.h"

namespace omni::tools {
namespace {

using protocol::SceneAction;

struct EditArguments {
  std::string socket, object, file;
  std::uint64_t client = 0;
  bool as_json = false;
  bool force = false;
};

std::string KiloBytes(double bytes) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.1f kB", bytes * 1e-3);
  return text;
}

// Prints why not; the exit status. With an answer: kExitOk.
int Request(const std::string& command, SceneAction action, const EditArguments& arguments,
            client::SceneAnswer& answer) {
  auto connection = ConnectToService(arguments.socket);
  if (!connection.ok()) return FailWith(arguments.as_json, command, connection.error(), kExitNoService);
  base::Result<client::SceneAnswer> answered = RequestScene(**connection, action, arguments.client, arguments.object);
  if (!answered.ok()) return FailWith(arguments.as_json, command, answered.error(), kExitNoService);
  answer = std::move(*answered);
  return answer.done ? kExitOk : FailWith(arguments.as_json, command, answer.text);
}

int Edits(const EditArguments& arguments) {
  client::SceneAnswer answer;
  if (const int status = Request("omni scene edits", SceneAction::kEdits, arguments, answer); status != kExitOk) {
    return status;
  }
  const nlohmann::json edits = ParseJsonOrNull(answer.text);
  if (!edits.is_object()) {
    return Fail("omni scene edits", "omnid's answer is not a JSON object; install the same Omni version for both");
  }
  if (arguments.as_json) {
    PrintJson(edits);
  } else {
    Print(EditsText(edits));
  }
  return kExitOk;
}

int Change(const char* command, SceneAction action, const EditArguments& arguments) {
  client::SceneAnswer answer;
  const int status = Request(command, action, arguments, answer);
  if (status == kExitOk) Print(answer.text + "\n");
  return status;
}

int Undo(const EditArguments& arguments) { return Change("omni scene undo", SceneAction::kUndo, arguments); }

int Redo(const EditArguments& arguments) { return Change("omni scene redo", SceneAction::kRedo, arguments); }

int Release(const EditArguments& arguments) { return Change("omni scene release", SceneAction::kRelease, arguments); }

int Save(const EditArguments& arguments) {
  constexpr const char* kCommand = "omni scene save";
  client::SceneAnswer answer;
  if (const int status = Request(kCommand, SceneAction::kSave, arguments, answer); status != kExitOk) return status;
  if (answer.file.compare(0, 4, "glTF") != 0) {
    return Fail(kCommand, "omnid sent no .glb file; install the same Omni version for both");
  }
  const base::Status written = WriteWholeFile(arguments.file, answer.file, arguments.force);
  if (!written.ok()) return Fail(kCommand, written.error());
  Print(arguments.file + ": " + answer.text + ", " + KiloBytes(static_cast<double>(answer.file.size())) + "\n");
  return kExitOk;
}

void AddPlace(Command command, const std::shared_ptr<EditArguments>& arguments) {
  command.Add("--client", arguments->client,
              "whose scene: the client's id in `omni status --json` (default: the owner's, or the only one)");
  AddSocket(command, arguments->socket);
}

}  // namespace

void AddSceneEdits(Command& scene) {
  auto arguments = std::make_shared<EditArguments>();
  Command edits = scene.AddCommand("edits", "list what was sculpted in the running service: objects, strokes, memory");
  edits.Add("--json", arguments->as_json, "as JSON");
  edits.SetAction(arguments, Edits);
  Command undo = scene.AddCommand("undo", "undo the last stroke of a sculpted object");
  undo.SetAction(arguments, Undo);
  Command redo = scene.AddCommand("redo", "redo the stroke that was undone last");
  redo.SetAction(arguments, Redo);
  for (Command command : {undo, redo}) {
    command.Add("--object", arguments->object, "name or number (default: the one edited last)");
  }
  Command release = scene.AddCommand("release", "let go of the clay that the pen holds; for a key or a foot switch");
  release.SetAction(arguments, Release);
  Command save = scene.AddCommand("save", "write the sculpted surfaces as a .glb file, as they are now");
  save.Add("file", arguments->file, "the file to write").Required().WritesOnly(".glb", "binary glTF");
  save.Add("--force", arguments->force, "replace an existing file");
  save.SetAction(arguments, Save);
  for (const Command& command : {edits, undo, redo, release, save}) AddPlace(command, arguments);
}

std::string EditsText(const nlohmann::json& edits) {
  std::string text = TextAt(edits, "/scene") + " (client " + TextAt(edits, "/client") + ")\n";
  for (const nlohmann::json& object : ArrayAt(edits, "/objects")) {
    text += "  " + TextAt(object, "/object") + "  " + TextAt(object, "/name") + ": " + TextAt(object, "/triangles") +
            " triangles, " + TextAt(object, "/strokes") + " strokes, " + TextAt(object, "/undone") +
            " undone, undo memory " + KiloBytes(NumberAt(object, "/undo_bytes")) + ", surface " +
            KiloBytes(NumberAt(object, "/page_bytes")) +
            (TrueAt(object, "/stroke_open") ? "; a stroke is in progress" : "") + "\n";
  }
  return text;
}

}  // namespace omni::tools
