// Training of the guide: sorts records into cells, splits cells, and fits their mixtures.
#include "kernels/guiding/guide_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace sheaf {

namespace {

/// Factor on the earlier passes' vertices in a mean, and minimum number of vertices for a mean.
constexpr double kMeanMemory = 0.5, kFewestVertices = 16;

/// Normal of the surfaces of a side; 0 for media.
Vec3f axis_of(std::uint32_t side) {
  const float sign = (side & 1u) != 0 ? -1.0f : 1.0f;
  if (side == kGuideMedia) return {0, 0, 0};
  return {side < 2 ? sign : 0.0f, side / 2 == 1 ? sign : 0.0f, side / 2 == 2 ? sign : 0.0f};
}

/// The bit of the Morton code that separates the halves of a cell at this depth.
std::uint32_t half_bit(int depth) { return 1u << (kGuideBits - 1 - depth); }

template <class F> void for_each_parallel(std::size_t count, std::size_t grain, F&& f) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain),
                    [&f](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) f(i);
                    });
}

}  // namespace

GuideField::GuideField() : mixtures_(1), means_(1, -1.0f) {}

GuideView GuideField::view() const {
  return {mixtures_.data(), roots_.empty() ? nullptr : roots_.data(), children_.data(), means_.data(), low_, scale_};
}

/// Fits the cube to all vertices of the first pass, and creates a cell per side.
void GuideField::place_cube(const std::vector<std::vector<GuideRecord>>& tasks) {
  Vec3f low{kInfinity, kInfinity, kInfinity}, high = -low;
  for (const auto& task : tasks)
    for (const GuideRecord& r : task) {
      low = {std::min(low.x, r.p.x), std::min(low.y, r.p.y), std::min(low.z, r.p.z)};
      high = {std::max(high.x, r.p.x), std::max(high.y, r.p.y), std::max(high.z, r.p.z)};
    }
  if (!(low.x <= high.x)) return;
  low_ = low;
  scale_ = static_cast<float>(1 << (kGuideBits / 3)) / std::max(max_component(high - low) * 1.0001f, 1e-20f);
  roots_.resize(std::size_t{kGuideSides} << kGuideTopBits);
  children_.resize(2);
  for (std::uint32_t side = 0; side < kGuideSides; ++side) {
    places_.push_back({0, side << kGuideTopBits, {}, first_mixture(axis_of(side)), 0, 0});
    put(side);
  }
}

/// Points the tree nodes of a cell to it.
void GuideField::put(std::uint32_t place) {
  const Place& p = places_[place];
  const std::uint32_t leaf = kGuideLeaf | (place + 1);
  if (p.depth > kGuideTopBits) {
    children_[p.node] = leaf;
    return;
  }
  std::fill_n(roots_.begin() + p.node, std::size_t{1} << (kGuideTopBits - p.depth), leaf);
}

/// Sorts the records of all tasks by cell; within a cell they keep their order. Returns the range of each cell.
std::vector<GuideField::Span> GuideField::sort_records(const std::vector<std::vector<GuideRecord>>& tasks) {
  if (places_.empty()) place_cube(tasks);
  const auto place_of = [](const GuideRecord& r) { return r.row() == 0 ? r.side() : r.row() - 1; };
  std::vector<Span> spans(places_.size(), {0, 0});
  if (places_.empty()) return spans;
  for (const auto& task : tasks)
    for (const GuideRecord& r : task) ++spans[place_of(r)].end;
  // Reserve the range of each cell.
  std::size_t begin = 0;
  for (Span& span : spans) {
    const std::size_t size = span.end;
    span = {begin, begin};
    begin += size;
  }
  records_.resize(begin);
  for (const auto& task : tasks)
    for (const GuideRecord& r : task) records_[spans[place_of(r)].end++] = r;
  return spans;
}

/// Splits a cell, then its first half, while it holds more than `split_records` records. Second halves are appended to
/// `spans` and split by learn().
void GuideField::split(std::size_t place, std::vector<Span>& spans, std::size_t split_records) {
  while (spans[place].end - spans[place].begin > split_records && places_[place].depth < kGuideBits) {
    const auto [begin, end] = spans[place];
    const std::uint32_t bit = half_bit(places_[place].depth);
    // Partition the records; both halves keep their order.
    const GuideView guide = view();
    std::vector<GuideRecord> upper;
    std::size_t middle = begin;
    for (std::size_t i = begin; i < end; ++i) {
      if ((guide_code<Scalar>(guide, records_[i].p) & bit) != 0)
        upper.push_back(records_[i]);
      else
        records_[middle++] = records_[i];
    }
    std::copy(upper.begin(), upper.end(), records_.begin() + static_cast<std::ptrdiff_t>(middle));

    // Share the statistics between the halves.
    halve(places_[place].sums);
    places_[place].found *= 0.5, places_[place].vertices *= 0.5;
    const int depth = ++places_[place].depth;
    Place other = places_[place];
    // Create the nodes.
    if (depth > kGuideTopBits) {
      const auto pair = static_cast<std::uint32_t>(children_.size());
      if (depth == kGuideTopBits + 1)
        roots_[places_[place].node] = pair / 2;
      else
        children_[places_[place].node] = pair / 2;
      children_.resize(pair + 2);
      places_[place].node = pair;
      other.node = pair + 1;
    } else {
      other.node += 1u << (kGuideTopBits - depth);
    }
    const auto second = static_cast<std::uint32_t>(places_.size());
    places_.push_back(other);
    spans[place] = {begin, middle};
    spans.push_back({middle, end});
    put(static_cast<std::uint32_t>(place));
    put(second);
  }
}

void GuideField::fit(std::size_t place, const Span& span) {
  Place& p = places_[place];
  const auto records = std::span(records_).subspan(span.begin, span.end - span.begin);
  if (!records.empty()) fit_mixture(records, p.mixture, p.sums);
  p.found *= kMeanMemory, p.vertices *= kMeanMemory;
  for (const GuideRecord& r : records) p.found += double{r.found};
  p.vertices += static_cast<double>(records.size());
  mixtures_[place + 1] = p.mixture;
  if (p.vertices > kFewestVertices) means_[place + 1] = static_cast<float>(p.found / p.vertices);
}

void GuideField::learn(const std::vector<std::vector<GuideRecord>>& tasks, std::size_t split_records) {
  std::vector<Span> spans = sort_records(tasks);
  // Newly created cells are appended, and are split in turn.
  for (std::size_t place = 0; place < spans.size(); ++place) split(place, spans, split_records);
  mixtures_.resize(places_.size() + 1);
  means_.assign(places_.size() + 1, -1.0f);
  for_each_parallel(places_.size(), 1, [&](std::size_t i) { fit(i, spans[i]); });
}

}  // namespace sheaf
