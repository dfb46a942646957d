// A servo step must not allocate, lock or wait: this program replaces malloc and the pthread locks and
// counts.
#include <atomic>
#include <cstdlib>
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <new>
#include <pthread.h>

#include "haptics/methods.h"
#include "haptics/servo_loop.h"
#include "tests/scenes/scenes.h"
#include "volume/removal.h"

namespace {
thread_local bool is_watched = false;
std::atomic<long> allocations{0}, locks{0};
void note(std::atomic<long>& counter) {
  if (is_watched) counter.fetch_add(1);
}
template <class F>
F* next(const char* name) {
  return reinterpret_cast<F*>(dlsym(RTLD_NEXT, name));
}
}  // namespace

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void __libc_free(void*);
void* malloc(std::size_t size) { return note(allocations), __libc_malloc(size); }
void* calloc(std::size_t n, std::size_t size) { return note(allocations), __libc_calloc(n, size); }
void* realloc(void* p, std::size_t size) { return note(allocations), __libc_realloc(p, size); }
void free(void* p) { note(allocations), __libc_free(p); }
int pthread_mutex_lock(pthread_mutex_t* m) noexcept {
  note(locks);
  static auto* real = next<int(pthread_mutex_t*)>("pthread_mutex_lock");
  return real(m);
}
int pthread_cond_wait(pthread_cond_t* c, pthread_mutex_t* m) {
  note(locks);
  static auto* real = next<int(pthread_cond_t*, pthread_mutex_t*)>("pthread_cond_wait");
  return real(c, m);
}
int pthread_rwlock_rdlock(pthread_rwlock_t* l) noexcept {
  note(locks);
  static auto* real = next<int(pthread_rwlock_t*)>("pthread_rwlock_rdlock");
  return real(l);
}
}

namespace trephine::haptics {
namespace {

TEST(ServoQuiet, AHundredThousandStepsOfEveryMethodNeitherAllocateNorLock) {
  data_tools::PhantomOptions options;
  options.size = glm::ivec3(96);
  options.psf_sigma_voxels = 1;
  const TouchScene scene = scenes::phantom_scene("shell", options);
  volume::VersionChannel channel(std::make_shared<volume::Version>(scene.base));
  const int reader = channel.open_reader();
  std::vector<std::unique_ptr<ProxyMethod>> methods;
  std::vector<ServoCore> cores;
  for (const MethodInfo& info : method_catalogue()) {
    methods.push_back(make_method(info.name).value());
    ASSERT_FALSE(methods.back()->prepare(scene).has_value());
    cores.emplace_back(scene, *methods.back(), ForceOptions{}, 1e-3);
  }
  VirtualDevice device(scenes::rough_walk(glm::dvec3(-50), glm::dvec3(50), 1.0, 100001, 3), {});
  ASSERT_FALSE(device.open().has_value());
  Ring<ServoRecord> ring(1 << 20);
  volume::RemovalEditor editor(std::make_shared<volume::Version>(scene.base), {scene.shapes[0].field});
  Histogram histogram;
  long contacts = 0;
  Pose pose;
  for (int i = 0; i < 100000; ++i) {
    if (i % 5000 == 0) {  // the edit thread's work, not watched
      editor.remove({pose.position_world, pose.position_world, 4});
      channel.publish(editor.publish());
    }
    is_watched = true;
    const volume::Version* version = channel.adopt(reader);
    device.read(i * 1e-3, pose);
    for (ServoCore& core : cores) {
      const ServoRecord record = core.step(*version, {pose});
      device.write(record.force_world);
      ring.push(record);
      histogram.add(100);
      contacts += record.has_contact;
    }
    is_watched = false;
  }
  EXPECT_EQ(allocations.load(), 0);
  EXPECT_EQ(locks.load(), 0);
  EXPECT_GT(contacts, 5000);
  // The counters can count.
  is_watched = true;
  void* volatile seen = std::malloc(10);  // volatile: compilers know that a freed malloc is nothing
  std::free(seen);
  pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
  pthread_mutex_lock(&mutex);
  pthread_mutex_unlock(&mutex);
  is_watched = false;
  EXPECT_EQ(allocations.load(), 2);
  EXPECT_EQ(locks.load(), 1);
}

}  // namespace
}  // namespace trephine::haptics
