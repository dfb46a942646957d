// Keeps libraries that talk to std::cerr and std::cout quiet for a scope: our own answer says what went
// wrong.
#pragma once

#include <iostream>
#include <sstream>

namespace trephine::data_tools {

/// Not for two threads at once, nor while another thread writes to these streams.
class QuietStreams {
 public:
  QuietStreams() : cerr_(std::cerr.rdbuf(swallowed_.rdbuf())), cout_(std::cout.rdbuf(swallowed_.rdbuf())) {}
  ~QuietStreams() { std::cerr.rdbuf(cerr_), std::cout.rdbuf(cout_); }
  QuietStreams(const QuietStreams&) = delete;
  QuietStreams& operator=(const QuietStreams&) = delete;

 private:
  std::ostringstream swallowed_;
  std::streambuf *cerr_, *cout_;
};

}  // namespace trephine::data_tools
