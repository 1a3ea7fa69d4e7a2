// Typed access to the properties of an object.
#include "scene/xml/properties.h"

#include "core/color/color.h"
#include "scene/xml/xml_values.h"

#include <algorithm>

namespace sheaf {

namespace {

const std::vector<std::string> kPropertyTags = {"float",   "integer", "boolean", "string",   "point",     "vector",
                                                "rgb",     "srgb",    "color",   "spectrum", "blackbody", "transform",
                                                "texture", "point2",  "vector2", "animation"};
const std::vector<std::string> kObjectTags = {"sensor", "camera",     "film", "sampler",      "rfilter", "integrator",
                                              "shape",  "mesh",       "bsdf", "emitter",      "medium",  "phase",
                                              "volume", "subsurface", "test", "phasefunction"};
constexpr std::size_t kMaxNesting = 100;

bool contains(const std::vector<std::string>& list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// Whether spelling_key(name) is `key`.
bool is_spelled(std::string_view name, std::string_view key) {
  std::size_t at = 0;
  for (const char c : name) {
    if (c == '_') continue;
    if (at == key.size() || key[at] != lower(c)) return false;
    ++at;
  }
  return at == key.size();
}

}  // namespace

void ReadContext::note(const SourceLocation& where, const std::string& message) {
  std::string note = SceneError(where, message).what();
  std::vector<std::string>& notes = remarks.notes;
  if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(std::move(note));
}

std::string spelling_key(std::string_view name) {
  std::string key;
  for (const char c : name)
    if (c != '_') key += lower(c);
  return key;
}

Properties::Properties(const XmlElement& object, ReadContext& context, const char* plugin)
    : object_(object), context_(context), is_replaced_(plugin != nullptr) {
  expect_attributes(object, {"type", "id", "name", "version"});
  type_ = plugin != nullptr ? plugin : object.attribute("type");
  entries_.reserve(object.children.size());
  for (const XmlElement& child : object.children) add(child);
  if (std::find(context.open.begin(), context.open.end(), &object) != context.open.end())
    raise(nullptr, title() + " refers to itself");
  if (context.open.size() >= kMaxNesting)
    raise(nullptr, "objects are nested deeper than 100 references", SceneErrorCode::kTooLarge);
  context.open.push_back(&object);
}

Properties::~Properties() { std::erase(context_.open, &object_); }

void Properties::expect_attributes(const XmlElement& element, std::initializer_list<const char*> allowed) const {
  try {
    element.expect_attributes(allowed);
  } catch (const SceneError& error) { context_.errors.report(error, "ignored"); }
}

void Properties::report_child(const XmlElement& child, const std::string& message, SceneErrorCode code) {
  context_.errors.report(SceneError(child.where, message, code).about(fmt::format("<{}> in {}", child.name, title())),
                         "ignored");
}

void Properties::add(const XmlElement& child) {
  const XmlElement* target = &child;
  // Resolve references
  if (child.name == "ref") {
    expect_attributes(child, {"id", "name"});
    try {
      target = &context_.scene.find(child.attribute("id"), child.where);
    } catch (const SceneError& error) { return context_.errors.report(error, "ignored"); }
  }
  const std::string* name = child.find_attribute("name");
  const bool nameless = name == nullptr || name->empty();
  // Add nested objects
  if (contains(kObjectTags, target->name) || (target->name == "texture" && nameless)) {
    entries_.emplace_back("", name != nullptr ? *name : "", child, *target);
    return;
  }
  if (!contains(kPropertyTags, target->name) && target->array == nullptr) {
    std::vector<std::string> known = kPropertyTags;
    known.insert(known.end(), kObjectTags.begin(), kObjectTags.end());
    known.push_back("ref");
    return report_child(
        child, fmt::format("unknown element <{}> in {}{}", target->name, title(), did_you_mean(target->name, known)),
        SceneErrorCode::kUnknownName);
  }
  // Add properties, each once
  if (nameless)
    return report_child(child, fmt::format("<{}> in {} needs an attribute 'name'", child.name, title()),
                        SceneErrorCode::kMissing);
  const std::string key = spelling_key(*name);
  const auto same = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.key == key; });
  if (same != entries_.end()) {
    const SceneError error(child.where, fmt::format("property {} is set twice, expected once", in_quotes(*name)),
                           SceneErrorCode::kDuplicate);
    context_.errors.report(error.about(subject(*same)), "the last one is used");
    entries_.erase(same);
  }
  entries_.emplace_back(key, *name, child, *target);
}

Properties::Entry* Properties::find_value(const char* name) {
  for (Entry& entry : entries_)
    if (!entry.key.empty() && !entry.dropped && is_spelled(name, entry.key)) return &entry;
  return nullptr;
}

const std::string& Properties::text_of(const Entry& entry, std::initializer_list<const char*> types) const {
  const bool fits = std::any_of(types.begin(), types.end(), [&](const char* t) { return entry.target->name == t; });
  if (!fits) fail_type(entry, *types.begin());
  expect_attributes(*entry.target, {"name", "id", "value"});
  if (!entry.target->children.empty())
    raise(&entry, fmt::format("<{}> has nested elements, expected none", entry.target->name));
  return entry.target->attribute("value");
}

bool Properties::is_texture(const char* name) {
  const Entry* entry = find_value(name);
  return entry != nullptr && entry->target->name == "texture";
}

const ArrayValue* Properties::find_array(const char* name) {
  Entry* entry = use(name);
  if (entry == nullptr) return nullptr;
  if (entry->target->array == nullptr) drop(*entry, type_error(*entry, "an array"));
  return entry->target->array.get();
}

std::vector<std::pair<std::string, const ArrayValue*>> Properties::arrays_with_prefix(std::string_view prefix) {
  std::vector<std::pair<std::string, const ArrayValue*>> found;
  for (Entry& entry : entries_) {
    if (entry.used || entry.target->array == nullptr || !entry.name.starts_with(prefix)) continue;
    entry.used = true;
    found.emplace_back(entry.name, entry.target->array.get());
  }
  return found;
}

bool Properties::is_string(const char* name) {
  note_query(name, "string");
  const Entry* entry = find_value(name);
  return entry != nullptr && entry->target->name == "string";
}

NamedValues::Number Properties::read_number(const NamedValue& value) const {
  const Entry& entry = entry_of(value);
  const std::string& text = text_of(entry, {"float", "integer"});
  const float number = parse_float(text, entry.target->where, "property " + in_quotes(entry.name));
  return {double{number}, in_quotes(text)};
}

NamedValues::Number Properties::read_integer(const NamedValue& value) const {
  const Entry& entry = entry_of(value);
  const std::string& text = text_of(entry, {"integer", "float"});
  const std::int64_t number = parse_integer(text, entry.target->where, "property " + in_quotes(entry.name));
  return {static_cast<double>(number), in_quotes(text)};
}

bool Properties::read_boolean(const NamedValue& value) const {
  const Entry& entry = entry_of(value);
  const std::string& text = text_of(entry, {"boolean"});
  return parse_boolean(text, entry.target->where, "property " + in_quotes(entry.name));
}

std::string Properties::read_string(const NamedValue& value) const { return text_of(entry_of(value), {"string"}); }

Vec3d Properties::read_vec3(const NamedValue& value) const {
  const Entry& entry = entry_of(value);
  if (entry.target->name != "point" && entry.target->name != "vector") fail_type(entry, "point or vector");
  return parse_vec3_element(*entry.target, 0);
}

Vec2f Properties::vec2(const char* name, Vec2f default_value) {
  note_query(name, "two numbers or a float", default_value);
  Entry* entry = use(name);
  if (entry == nullptr) return default_value;
  const XmlElement& target = *entry->target;
  if (target.name == "float" || target.name == "integer") {
    const std::optional<float> number = find_number(name);
    return number ? Vec2f{*number, *number} : default_value;
  }
  const auto read = [&] {
    const char* const types[] = {"vector2", "point2", "vector", "point"};
    if (std::find(std::begin(types), std::end(types), target.name) == std::end(types))
      fail_type(*entry, "vector2 or float");
    expect_attributes(target, {"name", "id", "value"});
    const std::vector<float> v =
        parse_floats(target.attribute("value"), target.where, "property " + in_quotes(entry->name));
    if (v.size() != 2) fail_value(*entry, fmt::format("has {} numbers, expected two", v.size()));
    return Vec2f{v[0], v[1]};
  };
  return attempt(*entry, read).value_or(default_value);
}

Transform Properties::transform(const char* name) {
  note_query(name, "transform", std::string("identity"));
  Entry* entry = use(name);
  if (entry == nullptr) return Transform();
  const auto read = [&] {
    if (entry->target->name != "transform") fail_type(*entry, "transform");
    return parse_transform(*entry->target);
  };
  const auto first_key = [&] { return parse_animation(*entry->target).reference(); };
  if (entry->target->name != "animation") return attempt(*entry, read).value_or(Transform());
  const std::optional<Transform> at_rest = attempt(*entry, first_key);
  if (at_rest)
    errors().report(make_error(entry, subject(*entry) + " is an <animation>, expected <transform>: it cannot move",
                               SceneErrorCode::kWrongType),
                    "placed as at the first key");
  return at_rest.value_or(Transform());
}

Placement Properties::placement(const char* name) {
  if (!is_animation(name)) return Placement(transform(name));
  note_query(name, "transform", std::string("identity"));
  Entry* entry = use(name);
  return attempt(*entry, [&] { return Placement(parse_animation(*entry->target)); }).value_or(Placement());
}

bool Properties::is_animation(const char* name) {
  const Entry* entry = find_value(name);
  return entry != nullptr && entry->target->name == "animation";
}

std::optional<SpectrumDescription> Properties::find_spectrum(const char* name, SpectrumRole role) {
  note_query(name, "spectrum");
  Entry* entry = use(name);
  if (entry == nullptr) return std::nullopt;
  return attempt(*entry, [&] {
    const XmlElement& target = *entry->target;
    const char* const types[] = {"rgb", "srgb", "color", "spectrum", "blackbody", "float", "integer"};
    if (std::find(std::begin(types), std::end(types), target.name) == std::end(types))
      fail_type(*entry, "rgb, srgb, spectrum or float");
    SpectrumDescription result = context_.readers.spectrum(target, role, context_);
    check_role(result, role, target.where, subject(*entry));
    return result;
  });
}

SpectrumDescription Properties::spectrum(const char* name, SpectrumDescription default_value, SpectrumRole role) {
  note_query(name, "spectrum", default_value);
  std::optional<SpectrumDescription> found = find_spectrum(name, role);
  return found ? *std::move(found) : std::move(default_value);
}

std::optional<SpectrumInput> Properties::find_spectrum_input(const char* name, SpectrumRole role) {
  note_query(name, "spectrum or texture");
  if (!is_texture(name)) return find_spectrum(name, role);
  Entry& entry = *use(name);
  return attempt(entry, [&] {
    SpectrumInput input = context_.readers.texture(*entry.target, context_);
    if (const auto* constant = std::get_if<SpectrumDescription>(&input))
      check_role(*constant, role, entry.target->where, subject(entry));
    return input;
  });
}

SpectrumInput Properties::spectrum_input(const char* name, SpectrumInput default_value, SpectrumRole role) {
  note_query(name, "spectrum or texture", default_value);
  return find_spectrum_input(name, role).value_or(std::move(default_value));
}

ScalarInput Properties::scalar_of(const Entry& entry, const SpectrumInput& input, NumberRange range) {
  if (const auto* texture = std::get_if<TextureId>(&input)) return context_.readers.scalar_texture(*texture, context_);
  const SpectrumDescription& spectrum = std::get<SpectrumDescription>(input);
  float number = 0;
  if (const auto* constant = std::get_if<SpectrumDescription::Constant>(&spectrum.value)) {
    number = constant->value;
  } else if (const auto* rgb = std::get_if<SpectrumDescription::Rgb>(&spectrum.value)) {
    number = luminance(rgb->value);
  } else {
    fail_value(entry, "is a spectrum, expected a number or a texture", SceneErrorCode::kWrongType);
  }
  check_range(entry, {double{number}, number_text(double{number})}, range);
  return number;
}

std::optional<ScalarInput> Properties::find_scalar_input(const char* name, NumberRange range) {
  note_query(name, "float or texture");
  Entry* entry = find_value(name);
  if (entry == nullptr || entry->target->name == "float" || entry->target->name == "integer")
    return find_number(name, range);
  use(name);
  const char* const types[] = {"texture", "spectrum", "rgb", "srgb", "color"};
  if (std::find(std::begin(types), std::end(types), entry->target->name) == std::end(types)) {
    drop(*entry, type_error(*entry, "float or texture"));
    return std::nullopt;
  }
  const std::optional<SpectrumInput> input = find_spectrum_input(name, SpectrumRole::kIor);
  if (!input) return std::nullopt;
  return attempt(*entry, [&] { return scalar_of(*entry, *input, range); });
}

ScalarInput Properties::scalar_input(const char* name, ScalarInput default_value, NumberRange range) {
  note_query(name, "float or texture", default_value);
  return find_scalar_input(name, range).value_or(default_value);
}

const char* Properties::first_color() const {
  const std::vector<std::string> kinds = {"rgb", "srgb", "color", "spectrum", "texture"};
  for (const Entry& entry : entries_)
    if (!entry.key.empty() && contains(kinds, entry.target->name)) return entry.name.c_str();
  return nullptr;
}

const XmlElement* Properties::take_first(bool (*fits)(const Entry& entry), const std::string& what) {
  Entry* found = nullptr;
  for (Entry& entry : entries_) {
    if (entry.used || entry.dropped || !fits(entry)) continue;
    if (found != nullptr)
      drop(entry, make_error(&entry, fmt::format("{} has a second {}, expected one", title(), what),
                             SceneErrorCode::kDuplicate));
    else
      found = &entry;
  }
  if (found == nullptr) return nullptr;
  found->used = true;
  return found->target;
}

const XmlElement* Properties::any_texture_or_color() {
  if (const XmlElement* texture = any_texture()) return texture;
  const auto is_color = [](const Entry& entry) {
    const std::string& kind = entry.target->name;
    return kind == "rgb" || kind == "srgb" || kind == "color" || kind == "spectrum";
  };
  return take_first(is_color, "color");
}

const XmlElement* Properties::any_texture() {
  note_query("texture", "texture");
  queried_kinds_.emplace_back("texture");
  return take_first([](const Entry& entry) { return entry.target->name == "texture"; }, "<texture>");
}

std::filesystem::path Properties::find_file(const std::string& file, const NamedValue& value) const {
  return context_.scene.find_file(file, entry_of(value).target->where);
}

std::vector<const XmlElement*> Properties::objects(const char* kind) {
  note_query(kind, kind);
  queried_kinds_.emplace_back(kind);
  std::vector<const XmlElement*> found;
  for (Entry& entry : entries_)
    if (entry.key.empty() && !entry.dropped && entry.target->name == kind) {
      entry.used = true;
      found.push_back(entry.target);
    }
  return found;
}

const XmlElement* Properties::object(const char* kind) {
  const std::vector<const XmlElement*> found = objects(kind);
  if (found.size() > 1)
    fail(fmt::format("has {} nested <{}>, expected one", found.size(), kind), SceneErrorCode::kDuplicate);
  return found.empty() ? nullptr : found[0];
}

const XmlElement* Properties::named_object(const char* kind, const char* name) {
  note_query(name, kind);
  if (!contains(queried_kinds_, kind)) queried_kinds_.emplace_back(kind);
  queried_objects_[kind].emplace_back(name);
  const std::string key = spelling_key(name);
  Entry* found = nullptr;
  for (Entry& entry : entries_) {
    if (!entry.key.empty() || entry.dropped || entry.target->name != kind || spelling_key(entry.name) != key) continue;
    if (found != nullptr)
      drop(entry, make_error(&entry,
                             fmt::format("{} has a second <{}> of the name {}, expected one", title(), kind,
                                         in_quotes(entry.name)),
                             SceneErrorCode::kDuplicate));
    else
      found = &entry;
  }
  if (found == nullptr) return nullptr;
  found->used = true;
  return found->target;
}

void Properties::drop_object(const XmlElement& object) {
  for (Entry& entry : entries_)
    if (entry.target == &object) entry.dropped = true;
}

bool Properties::ignore_prefixed(const char* prefix) {
  note_query(prefix, "ignored");
  const std::string key = spelling_key(prefix);
  bool any = false;
  for (Entry& entry : entries_) {
    if (!entry.key.starts_with(key)) continue;
    entry.used = any = true;
  }
  return any;
}

void Properties::ignore_all() {
  if (QueryRecorder* recorder = QueryRecorder::active()) recorder->finished.insert(title());
  for (Entry& entry : entries_) entry.used = true;
}

void Properties::reject_unused() {
  // In strict mode, the properties of an object whose plugin is unknown are of no interest
  const bool any_allowed = is_replaced_ && !errors().is_lenient();
  for (Entry& entry : entries_) {
    if (entry.used || entry.dropped || any_allowed) continue;
    if (entry.key.empty())
      report_unused_object(entry);
    else
      reject(entry);
  }
  if (QueryRecorder* recorder = QueryRecorder::active()) recorder->finished.insert(title());
}

void Properties::report_unused_object(const Entry& entry) {
  const std::string& kind = entry.target->name;
  if (kind == "texture")
    return report_child(*entry.written,
                        fmt::format("<{}> in {} needs an attribute 'name'", entry.written->name, title()),
                        SceneErrorCode::kMissing);
  std::string message = fmt::format("{} takes no nested <{}>", title(), kind);
  if (const auto known = queried_objects_.find(kind); known != queried_objects_.end()) {
    message += entry.name.empty() ? " without a name" : " of the name " + in_quotes(entry.name);
    message += did_you_mean(spelling_key(entry.name), known->second) + known_names(known->second);
  } else if (!queried_kinds_.empty()) {
    message += fmt::format(" (known: {})", joined(queried_kinds_));
  }
  report_child(*entry.written, message, SceneErrorCode::kUnknownName);
}

const SourceLocation& Properties::position_of(const NamedValue* value) const {
  return value != nullptr ? entry_of(*value).written->where : object_.where;
}

void Properties::replace_plugin(const SceneError& error, const char* substitute) {
  errors().report(error, fmt::format("rendered as '{}'", substitute));
  type_ = substitute;
  is_replaced_ = true;
}

void Properties::report(const std::string& message, SceneErrorCode code, std::string_view substitute) {
  errors().report(make_error(nullptr, fmt::format("{} {}", title(), message), code), substitute);
}

void Properties::fail_plugin(std::vector<std::string> known) const {
  std::sort(known.begin(), known.end());
  if (QueryRecorder* recorder = QueryRecorder::active())
    recorder->plugins[object_.name].insert(known.begin(), known.end());
  raise(nullptr,
        fmt::format("unknown {} plugin {}{}{}", object_.name, in_quotes(type_), did_you_mean(type_, known),
                    known_names(known)),
        SceneErrorCode::kUnknownName);
}

SceneError Properties::type_error(const Entry& entry, const char* expected) const {
  return make_error(&entry,
                    fmt::format("{} is given as <{}>, expected {}", subject(entry), entry.target->name, expected),
                    SceneErrorCode::kWrongType);
}

void Properties::fail_type(const Entry& entry, const char* expected) const { throw type_error(entry, expected); }

std::string Properties::title() const { return fmt::format("{} {}", object_.name, in_quotes(type_)); }

}  // namespace sheaf
