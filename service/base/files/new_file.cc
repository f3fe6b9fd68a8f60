#include "service/base/files/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

namespace omni::base {
namespace {

enum class What { kNothing, kFile, kLink, kFolder, kOther };

What At(const std::string& path) {
  struct stat info {};
  if (::lstat(path.c_str(), &info) != 0) return What::kNothing;
  if (S_ISREG(info.st_mode)) return What::kFile;
  if (S_ISLNK(info.st_mode)) return What::kLink;
  return S_ISDIR(info.st_mode) ? What::kFolder : What::kOther;
}

std::string Exists(const std::string& path) { return path + ": already exists; choose another name, or add --replace"; }

}  // namespace

Result<UniqueFd> MakeNewFile(const std::string& path) {
  const int create = At(path) == What::kOther ? 0 : O_CREAT | O_EXCL;
  UniqueFd file(::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW | create, 0644));
  if (file) return file;
  return Error{errno == EEXIST ? Exists(path) : WriteProblem(path, errno)};
}

std::string NewFileProblem(const std::string& path, bool replace) {
  const What what = At(path);
  if (what == What::kFolder) return path + ": is a folder; give a file's name";
  if (what == What::kOther) return ::access(path.c_str(), W_OK) == 0 ? std::string() : WriteProblem(path, errno);
  if (what != What::kNothing && !replace) return Exists(path);
  const std::filesystem::path parent = std::filesystem::path(path).parent_path();
  const std::string folder = parent.empty() ? "." : parent.string();
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) {
    return path + ": there is no folder " + folder + "; make it or name another one";
  }
  if (::access(folder.c_str(), W_OK | X_OK) == 0) return {};
  return path + ": cannot be made in " + folder + " (" + std::strerror(errno) + "); name another folder";
}

Status RemoveForNew(const std::string& path) {
  const What what = At(path);
  if (what != What::kFile && what != What::kLink) return Ok{};
  if (::unlink(path.c_str()) == 0 || errno == ENOENT) return Ok{};
  return Error{WriteProblem(path, errno)};
}

std::string FreeName(const std::string& path) {
  std::string name = path;
  for (int n = 2; At(name) == What::kFile || At(name) == What::kLink; ++n) name = path + "." + std::to_string(n);
  return name;
}

}  // namespace omni::base
