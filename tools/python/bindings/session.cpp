#include "tools/python/bindings/session.h"

#include "core/io/error.h"
#include "core/io/file_cache.h"
#include "core/io/inflate.h"
#include "core/io/memory.h"
#include "scene/compile/geometry/prepare_mesh.h"
#include "scene/dialects/read_model.h"
#include "scene/dialects/read_scene.h"
#include "tools/console/progress.h"
#include "tools/job/parts.h"
#include "tools/report/report_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <set>

namespace sheaf {

namespace {

/// The files of all scenes, which remain in memory while any scene exists.
class SharedFiles {
 public:
  /// Files that no scene has read since the last call are dropped.
  void open() {
    const std::lock_guard lock(mutex_);
    if (sessions_++ == 0) cache_.emplace();
    cache_->drop_unused();
  }
  void close() {
    const std::lock_guard lock(mutex_);
    if (--sessions_ == 0) cache_.reset();
  }

 private:
  std::mutex mutex_;
  int sessions_ = 0;
  std::optional<FileCache> cache_;
};

SharedFiles& shared_files() {
  static auto* const files = new SharedFiles;  // never destroyed: scenes may outlive static objects
  return *files;
}

/// Locks the mutex when no other render holds it. Throws if `stop` is set meanwhile.
std::unique_lock<std::timed_mutex> wait_for(std::timed_mutex& mutex, const std::atomic<bool>& stop) {
  constexpr std::chrono::milliseconds kInterval(50);
  std::unique_lock lock(mutex, std::defer_lock);
  while (!lock.try_lock_for(kInterval))
    if (stop) throw Error(ExitCode::kRuntime, "stopped while another call used the scene");
  return lock;
}

bool is_shape(const XmlElement& element) { return element.name == "shape" || element.name == "mesh"; }

/// Replaces the children with the names of the replacements; <camera> is another name of <sensor>.
void replace_children(XmlElement& root, const std::vector<XmlElement>& replacements) {
  const auto name_of = [](const XmlElement& e) { return e.name == "camera" ? std::string("sensor") : e.name; };
  std::erase_if(root.children, [&](const XmlElement& child) {
    return std::any_of(replacements.begin(), replacements.end(),
                       [&](const XmlElement& each) { return name_of(each) == name_of(child); });
  });
  root.children.insert(root.children.end(), replacements.begin(), replacements.end());
}

/// Options that the compiled scene does not depend on.
const std::set<std::string>& options_of_render_only() {
  static const std::set<std::string> names{"seed",    "threads",    "wave-size",     "aov",          "light-groups",
                                           "float",   "replicates", "guiding",       "caustics",     "clamp-indirect",
                                           "samples", "crop",       "spectral-bins", "no-timestamps"};
  return names;
}

/// Checksum of a tree with its arrays.
std::uint32_t check_sum_of(const XmlElement& element, std::uint32_t sum) {
  const auto add = [&sum](std::string_view text) { sum = check_sum({text.data(), text.size()}, sum); };
  add("<" + element.name);
  for (const XmlAttribute& attribute : element.attributes) add(fmt::format(" {}={}", attribute.name, attribute.value));
  if (const ArrayValue* array = element.array.get()) {
    add(array->text());
    const std::size_t number_bytes = array->type == ArrayValue::Type::kByte ? 1 : 4;
    sum = check_sum({static_cast<const char*>(array->data), array->size() * number_bytes}, sum);
  }
  for (const XmlElement& child : element.children) sum = check_sum_of(child, sum);
  add(">");
  return sum;
}

}  // namespace

/// One render: its options, and what follows from them.
struct Session::Job {
  Job() : program("sheaf", ""), command(add_render_options(program, arguments)) {}

  Program program;
  RenderArguments arguments;
  Command command;
  std::vector<GivenOption> given;
  std::string compiled_for;
  double build_seconds = 0;
  bool kept_scene = false, kept_accel = false;
};

Session::Session(const std::string& file, OptionValues options) : name_(file), read_values_(std::move(options)) {
  read_options_ = sheaf::read_options(file, read_values_);
  shared_files().open();
  try {
    const double start = Progress::steady_seconds();
    if (is_xml_scene(file)) {
      auto scene = std::make_shared<ExpandedScene>(expand_scene(file, read_options_));
      take(read_scene(*scene, name_, read_options_));
      expanded_ = std::move(scene);
    } else {
      take(read_scene(file, read_options_));
    }
    load_seconds_ = Progress::steady_seconds() - start;
  } catch (...) {
    shared_files().close();
    throw;
  }
}

Session::Session(XmlElement root, const std::string& name, const std::filesystem::path& folder, OptionValues options)
    : name_(name), read_values_(std::move(options)), is_changed_(true) {
  read_options_ = sheaf::read_options(name, read_values_);
  shared_files().open();
  try {
    const double start = Progress::steady_seconds();
    auto scene = std::make_shared<ExpandedScene>(std::move(root), folder, read_options_.lenient);
    take(read_scene(*scene, name_, read_options_));
    expanded_ = std::move(scene);
    load_seconds_ = Progress::steady_seconds() - start;
  } catch (...) {
    shared_files().close();
    throw;
  }
}

Session::~Session() { shared_files().close(); }

void Session::take(Description description) {
  {
    const std::lock_guard lock(tree_mutex_);
    summary_ = {description.film.width, description.film.height, description.notes, description.substitutions, {}};
    for (const MaterialDescription& material : description.materials) summary_.materials.push_back(material.where);
  }
  loaded_.description = std::move(description);
  replaced_.reset();
  compiled_for_.clear();
}

std::shared_ptr<const ExpandedScene> Session::expanded() const {
  const std::lock_guard lock(tree_mutex_);
  return expanded_;
}

Session::Summary Session::summary() const {
  const std::lock_guard lock(tree_mutex_);
  return summary_;
}

std::shared_ptr<const XmlElement> Session::tree() const {
  const std::shared_ptr<const ExpandedScene> scene = expanded();
  if (scene == nullptr)
    throw Error(ExitCode::kUsage,
                name_ + " cannot be changed or inspected: expected a scene of Mitsuba or Nori or from a dictionary");
  return {scene, &scene->root()};
}

void Session::edit(const std::function<void(XmlElement& root)>& change) {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock.owns_lock()) throw Error(ExitCode::kUsage, "the scene is in use by another call");
  const double start = Progress::steady_seconds();
  XmlElement root = *tree();
  change(root);
  auto changed = std::make_shared<ExpandedScene>(std::move(root), *expanded_);
  Description description = read_scene(*changed, name_, read_options_);
  {
    const std::lock_guard tree_lock(tree_mutex_);
    expanded_ = std::move(changed);
  }
  is_changed_ = true;
  take(std::move(description));
  load_seconds_ = Progress::steady_seconds() - start;
}

std::optional<Mesh> Session::mesh(std::size_t shape) const {
  const std::shared_ptr<const ExpandedScene> scene = expanded();
  XmlElement root = *tree();
  if (shape >= root.children.size() || !is_shape(root.children[shape])) return {};
  const XmlElement wanted = root.children[shape];
  std::erase_if(root.children, is_shape);
  root.children.push_back(wanted);
  ExpandedScene alone(std::move(root), *scene);
  const Description description = read_scene(alone, name_, read_options_);
  if (description.shapes.size() != 1 || !has_prepared_mesh(description.shapes.front())) return {};
  return prepare_mesh(description.shapes.front(), description.shutter).mesh;
}

std::filesystem::path Session::find_file(const std::string& name, const SourceLocation& where) const {
  return ExpandedScene(XmlElement(), *expanded()).find_file(name, where);
}

/// Reads a bare model again if it was framed for an image of another aspect ratio.
void Session::read_for_size(const RenderArguments& arguments) {
  if (!has_studio(loaded_.description)) return;
  const double aspect_ratio = sheaf::read_options(arguments).view.aspect_ratio;
  if (aspect_ratio == read_options_.view.aspect_ratio) return;
  read_options_.view.aspect_ratio = aspect_ratio;
  take(read_scene(name_, read_options_));
}

void Session::prepare_job(const OptionValues& options, const std::vector<XmlElement>& replacements, Job& job) {
  OptionValues values = options;
  values.insert(read_values_.begin(), read_values_.end());
  job.given = job.command.set(values);
  job.arguments.scene = name_;
  for (const GivenOption& option : job.given)
    if (!options_of_render_only().contains(option.name))
      job.compiled_for += fmt::format("--{}={}\n", option.name, option.values);
  choose_denoiser(job.arguments.denoiser);
  read_for_size(job.arguments);
  // Apply them to the scene as it was read
  if (replaced_) loaded_.description = std::move(*replaced_);
  replaced_.reset();
  if (!job.arguments.integrator.empty() || !replacements.empty()) replaced_ = loaded_.description;
  if (!replacements.empty()) {
    XmlElement root = *tree();
    replace_children(root, replacements);
    ExpandedScene changed(std::move(root), *expanded_);
    loaded_.description = read_scene(changed, name_, read_options_);
    for (const XmlElement& each : replacements) job.compiled_for += fmt::format("{:08x}\n", check_sum_of(each, 0));
  }
  prepare(job.arguments, loaded_);
}

void Session::compile_job(Job& job) {
  job.compiled_for += ".";  // not empty
  job.kept_scene = loaded_.scene != nullptr && compiled_for_ == job.compiled_for;
  job.kept_accel = job.kept_scene;
  if (job.kept_scene) {
    loaded_.compiled.texture_seconds = loaded_.compiled.mesh_seconds = loaded_.compiled.accel_seconds = 0;
    return;
  }
  const double start = Progress::steady_seconds();
  compiled_for_.clear();
  kept_.expects_changes = true;
  if (loaded_.scene != nullptr) keep_geometry(std::move(loaded_.scene), kept_);
  const Accel* const before = kept_.accel.get();
  sheaf::compile(job.arguments, loaded_, &kept_);
  job.kept_accel = before != nullptr && loaded_.scene->view().accel == before;
  compiled_for_ = job.compiled_for;
  job.build_seconds = Progress::steady_seconds() - start;
}

RecordedSettings Session::settings_of(const Job& job) const {
  RecordedSettings settings =
      recorded_settings(job.given, expanded_ != nullptr ? expanded_->files() : loaded_.description.files);
  if (is_changed_)
    settings.push_back(
        {"the scene of the program", fmt::format("{:08x}", check_sum_of(*tree(), 0)), RecordedSetting::Kind::kFile});
  return settings;
}

RenderedImage Session::render(const OptionValues& options, const std::vector<XmlElement>& replacements,
                              RenderWatch& watch) {
  const auto lock = wait_for(mutex_, watch.stop);
  Job job;
  prepare_job(options, replacements, job);
  compile_job(job);
  // Render
  RenderControl control = control_of(job.arguments);
  control.stop = &watch.stop;
  control.on_progress = [&watch](const RenderProgress& progress) {
    watch.total.store(progress.total, std::memory_order_relaxed);
    // Workers may report in any order
    std::uint64_t last = watch.done.load(std::memory_order_relaxed);
    while (last < progress.done && !watch.done.compare_exchange_weak(last, progress.done, std::memory_order_relaxed)) {}
  };
  RenderResult result = sheaf::render(*loaded_.scene, loaded_.settings, control);
  RenderReport& report = result.report;
  report.scene = name_;
  report.color = loaded_.color_name();
  add_loading(report, loaded_, load_seconds_, job.build_seconds);
  load_seconds_ = 0;
  report.peak_rss_bytes = peak_rss_bytes();
  report.peak_private_bytes = peak_private_bytes();
  // Make the image with its metadata
  RenderedImage out;
  out.image = result.to_image();
  out.metadata = make_metadata(job.arguments, loaded_, report, out.image);
  if (result.samples) report.spp = result.samples->count;
  if (!job.arguments.samples.empty() || !job.arguments.crop.empty())
    add_part_attributes(out.metadata, part_settings(settings_of(job)), result.samples);
  add_denoised(job.arguments, out.image, out.metadata);
  out.stats = to_json(report);
  out.warnings = scene_warnings(loaded_);
  out.warnings.insert(out.warnings.end(), result.warnings.begin(), result.warnings.end());
  out.notes = loaded_.remarks.notes;
  out.interrupted = result.interrupted;
  out.has_studio = has_studio(loaded_.description);
  out.kept_scene = job.kept_scene;
  out.kept_accel = job.kept_accel;
  return out;
}

void Session::with_scene(const OptionValues& options, const std::function<void(const LoadedScene&)>& use) {
  const std::lock_guard lock(mutex_);
  Job job;
  prepare_job(options, {}, job);
  compile_job(job);
  use(loaded_);
}

}  // namespace sheaf
