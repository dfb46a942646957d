// Operations that Python uses, and their opening.
#pragma once

#include <atomic>
#include <memory>
#include <stdexcept>
#include <unistd.h>
#include <utility>

#include "apps/api/operation.h"
#include "apps/python/arrays.h"

namespace trephine::python {

/// An operation that one thread at a time may use: a second thread gets an exception.
class PyOperation {
 public:
  explicit PyOperation(Operation operation) : operation_(std::move(operation)) {}

  /// Calls use(operation) without the interpreter's lock.
  template <class Use>
  auto with(Use&& use) {
    if (getpid() != process_)
      throw std::runtime_error("the operation belongs to another process; open one after the fork");
    if (is_busy_.exchange(true))
      throw std::runtime_error("another thread uses this operation; open one operation per thread");
    struct Release {
      std::atomic<bool>& flag;
      ~Release() { flag = false; }
    } release{is_busy_};
    py::gil_scoped_release unlocked;
    return use(operation_);
  }

 private:
  Operation operation_;
  pid_t process_ = getpid();
  std::atomic<bool> is_busy_ = false;
};
using SharedOperation = std::shared_ptr<PyOperation>;

SharedOperation open(const py::object& source, const py::kwargs& keywords);
SharedOperation reopen(const py::object& session, const py::object& scan);

}  // namespace trephine::python
