// The cost of each BSDF at a vertex: one evaluation, as for light sampling, and one sample. Parameters differ between
// lanes. "per_item" is in seconds.
#include "kernels/wave/path_state.h"
#include "tests/support/any_bsdf.h"

#include <benchmark/benchmark.h>

#include <string>

namespace sheaf {

namespace {

constexpr int kItems = 512;

/// The inputs of evaluation and sampling.
template <class L> struct Query {
  Vec3<L> wo, wi;
  typename L::Float u, v, w;
  static constexpr auto fields(auto& s) { return std::tie(s.wo, s.wi, s.u, s.v, s.w); }
};

/// The results, stored so that the compiler does not remove their computation.
template <class L> struct Answer {
  Spectrum<L> f_cos, weight;
  Vec3<L> wi;
  typename L::Float pdf, sample_pdf;
  static constexpr auto fields(auto& s) { return std::tie(s.f_cos, s.weight, s.wi, s.pdf, s.sample_pdf); }
};

Random4<Scalar> numbers(int i, std::uint32_t stream) {
  return random4<Scalar>(stream, static_cast<std::uint32_t>(i), 0, 0);
}

Vec3f direction(int i, std::uint32_t stream) {
  const auto u = numbers(i, stream);
  return square_to_cosine_hemisphere<Scalar>(u.x, u.y);
}

template <class L, template <class> class Bsdf> void vertex(benchmark::State& state) {
  Arena arena(Soa<Query>::bytes(kItems) + Soa<ClosureItem>::bytes(kItems) + Soa<Answer>::bytes(kItems));
  Soa<Query> queries;
  Soa<ClosureItem> parameters;
  Soa<Answer> answers;
  queries.bind(arena, kItems);
  parameters.bind(arena, kItems);
  answers.bind(arena, kItems);
  float* const* words = parameters.columns().words;
  const float* tables = any_tables().floats.data();
  for (int i = 0; i < kItems; ++i) {
    const auto u = numbers(i, 3);
    queries.template store<Scalar>(i, {direction(i, 1), direction(i, 2), u.x, u.y, u.z});
    int k = 0;
    const Bsdf<Scalar> bsdf = any_bsdf<Bsdf>(static_cast<std::uint32_t>(i));
    std::apply([&](const auto&... leaf) { ((words[k++][i] = word_of_leaf(leaf)), ...); }, leaves(bsdf));
  }
  for (auto _ : state) {
    for (int i = 0; i < kItems; i += L::width) {
      const auto q = queries.template load<L>(i);
      const auto bsdf = bsdf_of_words<Bsdf<L>>(
          tables, [words, i](int k, Float<L>& word) SHEAF_LAMBDA_INLINE { load(words[k] + i, word); });
      const BsdfValue<L> value = bsdf.evaluate(q.wo, q.wi);
      const BsdfSample<L> sample = bsdf.sample(q.wo, {q.u, q.v, q.w, q.u});
      answers.template store<L>(i,
                                {value.f_cos, sample.weight, sample.wi, value.pdf_solid_angle, sample.pdf_solid_angle});
    }
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * kItems);
  state.counters["per_item"] =
      benchmark::Counter(kItems, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

const bool kRegistered = [] {
  for_each_bsdf([]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    const std::string name = std::string("bsdf/") + closure_info(kind).name;
    benchmark::RegisterBenchmark((name + "/wide").c_str(), vertex<Wide, Bsdf>);
    benchmark::RegisterBenchmark((name + "/scalar").c_str(), vertex<Scalar, Bsdf>);
  });
  return true;
}();

}  // namespace

}  // namespace sheaf
