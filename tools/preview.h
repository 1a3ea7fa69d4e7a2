// What can be seen of a render while it runs: in the viewer tev, and as a page for browsers.
#pragma once

#include "core/image.h"
#include "core/stats.h"
#include "tools/options.h"

#include <atomic>
#include <memory>
#include <string>

namespace sheaf {

class LivePage;
class TevViewer;
struct RenderOptions;
struct RenderState;

/// The options.
struct PreviewArguments {
  std::string tev;    ///< HOST:PORT; empty: none
  std::string serve;  ///< PORT or ADDRESS:PORT; empty: none
};

void add_preview_options(Command& command, PreviewArguments& arguments);

/// Shows one render, from its construction to its destruction, after which nothing is left open.
///
/// Pictures are made while the render pauses, only for those who look, and so seldom that they take a fiftieth of the
/// time at most. What the render computes stays the same to the bit.
class Preview {
 public:
  /// Begins to listen and to look for the viewer, if there are to be any. `name`: of the picture. Throws Error: exit
  /// code 2 for addresses that are none, 1 where it cannot listen and for hosts that are not known.
  Preview(const PreviewArguments& arguments, const std::string& scene, const std::string& name, bool quiet);
  ~Preview();
  Preview(const Preview&) = delete;
  Preview& operator=(const Preview&) = delete;

  /// The render begins: adds what it needs to what `options` call already. They must not outlive it.
  void watch(RenderOptions& options);
  /// The render has ended, and its files are being made.
  void begin_writing();
  /// Shows the finished picture. Gives those who look a moment to fetch it: at most 5 seconds a viewer, 3 seconds
  /// browsers, and none where nobody looks. `state`: what to call it, "done" or "interrupted" ...
  void finish(const std::string& state, const Image& picture, const RenderReport& report);

 private:
  bool is_due();
  void show(const RenderState& state);

  std::unique_ptr<LivePage> page_;  ///< null: none is wanted
  std::unique_ptr<TevViewer> tev_;  ///< likewise
  std::atomic<double> next_{0};     ///< when the next picture may be made, seconds on the steady clock
  std::atomic<double> asked_{0};    ///< when the render was asked to pause for it; 0: it was not
};

}  // namespace sheaf
