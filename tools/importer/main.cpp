// sheaf_import_model FILE MEMORY SECONDS: converts a model to a binary glTF file on the standard output, by Assimp.
//
// It is a program of its own because Assimp's importers may crash on damaged files. MEMORY (bytes of address space; 0:
// unlimited) and SECONDS (of processor time) limit it. Exit status: 0 done; 3 failed, with a message for the user on
// the standard output.
#include "tools/importer/collada.h"
#include "tools/importer/conversion.h"
#include "tools/importer/fbx_parts.h"
#include "tools/importer/sandbox.h"

#include <assimp/BaseImporter.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <fmt/format.h>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>

#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <new>

namespace sheaf::importer {

namespace {

constexpr int kFailed = 3;

/// A file in memory.
class MemoryFile : public Assimp::IOStream {
 public:
  explicit MemoryFile(const std::string& bytes) : bytes_(bytes) {}

  std::size_t Read(void* to, std::size_t size, std::size_t count) override {
    if (size == 0) return 0;
    count = std::min(count, (bytes_.size() - at_) / size);
    std::memcpy(to, bytes_.data() + at_, size * count);
    at_ += size * count;
    return count;
  }
  std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }
  aiReturn Seek(std::size_t offset, aiOrigin origin) override {
    if (origin == aiOrigin_CUR) offset += at_;
    if (origin == aiOrigin_END) offset = bytes_.size() - offset;
    if (offset > bytes_.size()) return aiReturn_FAILURE;
    at_ = offset;
    return aiReturn_SUCCESS;
  }
  std::size_t Tell() const override { return at_; }
  std::size_t FileSize() const override { return bytes_.size(); }
  void Flush() override {}

 private:
  const std::string& bytes_;
  std::size_t at_ = 0;
};

/// A file system with a single file.
class OneFile : public Assimp::IOSystem {
 public:
  OneFile(std::string name, const std::string& bytes) : name_(std::move(name)), bytes_(bytes) {}

  bool Exists(const char* file) const override { return name_ == file; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    return Exists(file) && mode[0] == 'r' ? new MemoryFile(bytes_) : nullptr;
  }
  void Close(Assimp::IOStream* file) override { delete file; }

 private:
  std::string name_;
  const std::string& bytes_;
};

/// Leaves only the reader of one format. Throws ImportError if this version of Assimp lacks it.
void keep_reader(Assimp::Importer& importer, const std::string& format) {
  const Assimp::BaseImporter* const requested = importer.GetImporter(("." + format).c_str());
  if (requested == nullptr) throw ImportError(fmt::format("this version of Assimp does not read .{} files", format));
  for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
    Assimp::BaseImporter* const reader = importer.GetImporter(i);
    if (reader == requested) continue;
    importer.UnregisterLoader(reader);
    delete reader;
  }
}

[[noreturn]] void fail(const Assimp::Importer& importer) {
  const std::string reason = importer.GetErrorString();
  if (reason.find("bad_alloc") != reason.npos) throw std::bad_alloc();
  throw ImportError("cannot be read: " + reason);
}

/// Reads the parts that Assimp does not pass on, and removes those from the file that it cannot read.
FileParts take_parts(const std::string& format, std::string& bytes) {
  if (format == "fbx") return fbx_parts(bytes);
  return format == "dae" ? take_collada_parts(bytes) : FileParts();
}

std::string convert(const std::string& format, std::string bytes) {
  FileParts parts = take_parts(format, bytes);
  Assimp::Importer importer;
  const std::string name = "model." + format;
  importer.SetIOHandler(new OneFile(name, bytes));  // owned by the importer
  keep_reader(importer, format);
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  constexpr float kCrease = 50;  // degrees, as for other models
  importer.SetPropertyFloat(AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, kCrease);
  unsigned flags = 0;
  if (format == "3ds") {
    // Assimp's normals of faces without a smoothing group are smooth, but those faces are flat.
    importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS, aiComponent_NORMALS);
    flags |= aiProcess_RemoveComponent;
  }
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_CAMERAS, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_LIGHTS, false);
  if (importer.ReadFile(name, aiProcess_ValidateDataStructure) == nullptr) fail(importer);
  if (format == "off") prepare_off(const_cast<aiScene&>(*importer.GetScene()));
  // Triangulate before the steps that compute normals from triangles
  triangulate(const_cast<aiScene&>(*importer.GetScene()), parts.notes);
  const aiScene* const scene = importer.ApplyPostProcessing(
      flags | aiProcess_SortByPType | aiProcess_GenSmoothNormals | aiProcess_TransformUVCoords |
      aiProcess_JoinIdenticalVertices | aiProcess_LimitBoneWeights);
  if (scene == nullptr || scene->mRootNode == nullptr) fail(importer);
  if (format != "fbx" && format != "dae") parts = assimp_parts(*scene);
  return to_glb(*scene, format, std::move(parts));
}

void write_all(const std::string& bytes) {
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t written = write(STDOUT_FILENO, bytes.data() + at, bytes.size() - at);
    if (written <= 0) _exit(kFailed);
    at += static_cast<std::size_t>(written);
  }
}

int run(const std::filesystem::path& file, std::uint64_t memory, std::uint64_t seconds) {
  std::string format = file.extension().string();
  format.erase(0, 1);
  for (char& c : format) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  try {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) throw ImportError("cannot be opened for reading");
    std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    restrict_process(memory, seconds);
    write_all(convert(format, std::move(bytes)));
    return 0;
  } catch (const ImportError& error) { write_all(error.what()); } catch (const std::bad_alloc&) {
    write_all("needs too much memory, or names a false size");
  } catch (const std::exception& error) { write_all(std::string("cannot be read: ") + error.what()); }
  return kFailed;
}

}  // namespace

}  // namespace sheaf::importer

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // end with the program that waits for the result
  const int status =
      sheaf::importer::run(argv[1], std::strtoull(argv[2], nullptr, 10), std::strtoull(argv[3], nullptr, 10));
  // Not exit(): Assimp leaks memory on errors, which leak checkers would report by another status.
  _exit(status);
}
