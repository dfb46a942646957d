// QuietStreams: discards output of libraries to std::cerr and std::cout within a scope. Functions that use
// it report errors in their results.
#pragma once

#include <iostream>
#include <sstream>

namespace trephine::data_tools {

/// Not thread-safe: no other thread may use a QuietStreams or write to these streams at the same time.
class QuietStreams {
 public:
  QuietStreams() : cerr_(std::cerr.rdbuf(discarded_.rdbuf())), cout_(std::cout.rdbuf(discarded_.rdbuf())) {}
  ~QuietStreams() { std::cerr.rdbuf(cerr_), std::cout.rdbuf(cout_); }
  QuietStreams(const QuietStreams&) = delete;
  QuietStreams& operator=(const QuietStreams&) = delete;

 private:
  std::ostringstream discarded_;
  std::streambuf *cerr_, *cout_;
};

}  // namespace trephine::data_tools
