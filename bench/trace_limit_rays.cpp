// Recording of rays, and tracing them again without the rest of the renderer.
#include "bench/trace_limit.h"

#include "core/simd/flush_denormals.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace sheaf {

namespace {

/// Packets per block, with about as many rays as one task of the renderer traces.
constexpr std::size_t kBlockPackets = 4096;

template <class Packet> auto ray_columns(Packet& p) {
  return std::array{p.origin_x, p.origin_y, p.origin_z, p.direction_x, p.direction_y, p.direction_z, p.t_far};
}

}  // namespace

struct RayLog::Block {
  std::size_t size = 0;
  PacketRecord packets[kBlockPackets];

  void replay(const Accel& accel) const {
    const FlushDenormals flush;
    RayPacket packet;
    const auto columns = ray_columns(packet);
    for (std::size_t i = 0; i < size; ++i) {
      const PacketRecord& record = packets[i];
      for (std::size_t k = 0; k < columns.size(); ++k)
        std::memcpy(columns[k], record.columns[k], sizeof(record.columns[k]));
      if (record.query == RayRecorder::Query::kAny) {
        accel.occluded(packet, record.count);
      } else {
        std::fill_n(packet.shape, kPacketWidth, kNone);
        accel.intersect(packet, record.count);
      }
    }
  }
};

class RayLog::Worker : public RayRecorder {
 public:
  explicit Worker(RayLog& log) : log_(log) {}

  void record(const RayPacket& packet, int count, Query query) override {
    if ((blocks_.empty() || blocks_.back()->size == kBlockPackets) && !add_block()) return;
    PacketRecord& record = blocks_.back()->packets[blocks_.back()->size++];
    const auto columns = ray_columns(packet);
    for (std::size_t k = 0; k < columns.size(); ++k)
      std::memcpy(record.columns[k], columns[k], sizeof(record.columns[k]));
    record.count = count;
    record.query = query;
  }

  const std::vector<std::unique_ptr<Block>>& blocks() const { return blocks_; }

 private:
  bool add_block() {
    const std::lock_guard lock(log_.mutex_);
    if (log_.blocks_ == log_.max_blocks_) return log_.complete_ = false;
    ++log_.blocks_;
    blocks_.push_back(std::make_unique<Block>());
    return true;
  }

  RayLog& log_;
  std::vector<std::unique_ptr<Block>> blocks_;
};

Duration Stopwatch::elapsed() const {
  return {static_cast<double>(timestamp() - start_) * seconds_per_tick(),
          static_cast<double>(std::clock() - cpu_start_) / CLOCKS_PER_SEC};
}

RayLog::RayLog(std::size_t max_packets) : max_blocks_((max_packets + kBlockPackets - 1) / kBlockPackets) {}

RayLog::~RayLog() = default;

RayRecorder* RayLog::add_worker() {
  const std::lock_guard lock(mutex_);
  return workers_.emplace_back(std::make_unique<Worker>(*this)).get();
}

bool RayLog::complete() const { return complete_; }

std::size_t RayLog::packets() const {
  std::size_t sum = 0;
  for (const auto& worker : workers_)
    for (const auto& block : worker->blocks()) sum += block->size;
  return sum;
}

std::size_t RayLog::rays() const {
  std::size_t sum = 0;
  for (const auto& worker : workers_)
    for (const auto& block : worker->blocks())
      for (std::size_t i = 0; i < block->size; ++i) sum += static_cast<std::size_t>(block->packets[i].count);
  return sum;
}

Duration RayLog::replay(const Accel& accel, int threads) const {
  std::vector<const Block*> blocks;
  for (const auto& worker : workers_)
    for (const auto& block : worker->blocks()) blocks.push_back(block.get());
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  const Stopwatch watch;
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, blocks.size(), 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          for (std::size_t i = range.begin(); i < range.end(); ++i) blocks[i]->replay(accel);
        },
        tbb::simple_partitioner());
  });
  return watch.elapsed();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return 0.5 * (values[values.size() / 2] + values[(values.size() - 1) / 2]);
}

}  // namespace sheaf
