// A scene of a Python program: read once, changed and rendered any number of times. It takes the same steps as `sheaf
// render` (tools/job/render_job.h).
#pragma once

#include "scene/compile/geometry/kept_geometry.h"
#include "scene/xml/xml_expand.h"
#include "tools/farm/merge_parts.h"
#include "tools/job/render_job.h"

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace sheaf {

/// An image with its metadata, as files hold it, and what is known of its render.
struct RenderedImage {
  Image image;
  ExrMetadata metadata;
  std::string stats = {};                  ///< the content of --stats; empty: unknown
  std::vector<std::string> warnings = {};  ///< about the scene and the render
  std::vector<std::string> notes = {};
  bool interrupted = false;
  bool has_studio = false;  ///< the scene is a bare model; see scene/dialects/read_model.h
  bool kept_scene = false;  ///< the compiled scene of the last render was used
  bool kept_accel = false;  ///< its acceleration structure was used, or updated for changed vertices
};

/// State that another thread reads and sets while a render runs.
struct RenderWatch {
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> done{0}, total{0};  ///< samples
};

/// Options by their names on the command line, without dashes.
using OptionValues = std::map<std::string, OptionValue>;

/// Indices of children, from the root of a tree to an element.
using TreePath = std::vector<std::size_t>;

/// Safe to use from several threads. Renders and queries wait for each other: the compiled scene is that of one call. A
/// change while another call uses the scene throws Error (exit code 2).
class Session {
 public:
  /// Reads a file. `options`: those that read_options.h declares. Throws Error.
  Session(const std::string& file, OptionValues options);
  /// Reads a tree, whose relative paths refer to `folder`. `name`: of the scene in messages. Throws Error.
  Session(XmlElement root, const std::string& name, const std::filesystem::path& folder, OptionValues options);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Whether the scene is a tree that can be changed.
  bool has_tree() const { return expanded() != nullptr; }
  /// The root of the tree, as it is now. Throws Error (exit code 2) without one.
  std::shared_ptr<const XmlElement> tree() const;
  /// Calls `change` for a copy of the tree, and reads it. If that fails, the scene remains as it was.
  void edit(const std::function<void(XmlElement& root)>& change);

  /// Renders. `options`: those of `sheaf render`. `replacements`: elements that replace those of their names in the
  /// root, such as <sensor>, for this render. Throws Error.
  RenderedImage render(const OptionValues& options, const std::vector<XmlElement>& replacements, RenderWatch& watch);

  /// Calls `use` with the scene compiled for a render with these options.
  void with_scene(const OptionValues& options, const std::function<void(const LoadedScene&)>& use);

  /// The mesh of the shape with this index in the root: world space, without degenerate triangles. Nothing for shapes
  /// that are not meshes, rectangles or cubes. Throws Error.
  std::optional<Mesh> mesh(std::size_t shape) const;

  /// The file `name` that an element at `where` refers to. Throws Error.
  std::filesystem::path find_file(const std::string& name, const SourceLocation& where) const;

  const std::string& name() const { return name_; }
  /// What is known of the scene as it was read.
  struct Summary {
    int width = 0, height = 0;
    std::vector<std::string> notes, substitutions;
    std::vector<SourceLocation> materials;  ///< location of each material, in the order of their numbers
  };
  Summary summary() const;

 private:
  struct Job;
  void take(Description description);
  std::shared_ptr<const ExpandedScene> expanded() const;
  void read_for_size(const RenderArguments& arguments);
  void prepare_job(const OptionValues& options, const std::vector<XmlElement>& replacements, Job& job);
  void compile_job(Job& job);
  RecordedSettings settings_of(const Job& job) const;

  std::timed_mutex mutex_;         ///< of all members but those below
  mutable std::mutex tree_mutex_;  ///< of expanded_ and summary_, which other threads read during a render
  std::shared_ptr<const ExpandedScene> expanded_;  ///< null for formats other than XML
  Summary summary_;
  std::string name_;
  OptionValues read_values_;
  ReadOptions read_options_;
  bool is_changed_ = false;  ///< the tree is not that of the file
  LoadedScene loaded_;
  std::optional<Description> replaced_;  ///< the scene as read, if options or replacements have changed it
  double load_seconds_ = 0;
  KeptGeometry kept_;
  std::string compiled_for_;  ///< the options that the compiled scene depends on
};

/// The options for reading a file. Throws Error (exit code 2).
ReadOptions read_options(const std::string& file, const OptionValues& values);

/// The options of `sheaf render` that apply to renders in a program, and those of reading and of writing images.
std::vector<OptionHelp> render_option_list();
std::vector<OptionHelp> read_option_list();
std::vector<OptionHelp> output_option_list();

/// The plugins of Mitsuba's dialect, by element. Read from the errors about unknown plugins.
std::map<std::string, std::vector<std::string>> plugin_names();

/// Writes an image file, or encodes it as PNG. `options`: those that output_options.h declares. Throws Error.
void write_result(const RenderedImage& result, const std::string& file, const OptionValues& options);
std::vector<unsigned char> encode_png(const RenderedImage& result, const OptionValues& options);

/// Reads an image of any format. Throws SceneError.
RenderedImage read_result(const std::string& file);

/// See tools/farm/merge_parts.h. Throws Error.
RenderedImage merge_results(const std::vector<const RenderedImage*>& parts, const MergeOptions& options);

/// See kernels/denoise/denoise.h. Throws Error.
RenderedImage denoise_result(const RenderedImage& result, const std::string& method, int threads);

}  // namespace sheaf
