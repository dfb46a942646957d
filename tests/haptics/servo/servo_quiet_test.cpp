// A servo step must not allocate, lock or wait. This program replaces malloc, calloc, realloc, free,
// and the locks and waits of pthread with functions that count their calls.
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <new>
#include <pthread.h>
#include <thread>

#include "apps/bench/scenes/scenes.h"
#include "haptics/device/composite_device.h"
#include "haptics/device/mapped_device.h"
#include "haptics/force/effects.h"
#include "haptics/mesh/mesh_tree.h"
#include "haptics/methods/methods.h"
#include "haptics/servo/servo_loop.h"
#include "volume/cuts/removal.h"
#include "volume/fields/offset_field.h"

namespace {
thread_local bool is_watched = false;
std::atomic<long> allocations{0}, locks{0};
void count(std::atomic<long>& counter) {
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
void* __libc_memalign(std::size_t, std::size_t);
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return count(allocations), __libc_memalign(alignment, size);
}
int posix_memalign(void** p, std::size_t alignment, std::size_t size) {
  count(allocations);
  *p = __libc_memalign(alignment, size);
  return *p ? 0 : ENOMEM;
}
void* malloc(std::size_t size) { return count(allocations), __libc_malloc(size); }
void* calloc(std::size_t n, std::size_t size) { return count(allocations), __libc_calloc(n, size); }
void* realloc(void* p, std::size_t size) { return count(allocations), __libc_realloc(p, size); }
void free(void* p) { count(allocations), __libc_free(p); }
int pthread_mutex_lock(pthread_mutex_t* m) noexcept {
  count(locks);
  static auto* real = next<int(pthread_mutex_t*)>("pthread_mutex_lock");
  return real(m);
}
int pthread_mutex_trylock(pthread_mutex_t* m) noexcept {
  count(locks);
  static auto* real = next<int(pthread_mutex_t*)>("pthread_mutex_trylock");
  return real(m);
}
int pthread_rwlock_wrlock(pthread_rwlock_t* l) noexcept {
  count(locks);
  static auto* real = next<int(pthread_rwlock_t*)>("pthread_rwlock_wrlock");
  return real(l);
}
int pthread_cond_wait(pthread_cond_t* c, pthread_mutex_t* m) {
  count(locks);
  static auto* real = next<int(pthread_cond_t*, pthread_mutex_t*)>("pthread_cond_wait");
  return real(c, m);
}
int pthread_rwlock_rdlock(pthread_rwlock_t* l) noexcept {
  count(locks);
  static auto* real = next<int(pthread_rwlock_t*)>("pthread_rwlock_rdlock");
  return real(l);
}
}

namespace trephine::haptics {
namespace {

TEST(ServoQuiet, EveryPointMethodNeitherAllocatesNorLocksIn100000Steps) {
  data_tools::PhantomOptions options;
  options.size = glm::ivec3(96);
  options.psf_sigma_voxels = 1;
  const TouchScene scene = scenes::phantom_scene("shell", options);
  std::vector<std::unique_ptr<ProxyMethod>> methods;
  std::vector<ServoCore> cores;
  ServoScene next;
  const auto first = std::make_shared<volume::Version>(scene.base);
  for (const MethodInfo& info : method_catalogue()) {
    if (!info.takes_points) continue;
    methods.push_back(make_method(info.name).value());
    ASSERT_FALSE(methods.back()->prepare(scene).has_value());
    cores.emplace_back(ForceOptions{}, 1e-3, next.hands.size());
    next.hands.emplace_back(borrowed(scene), borrowed(*methods.back()), TouchState(first));
  }
  ServoChannel channel(std::make_shared<ServoScene>(next));
  const int reader = channel.open_reader();
  VirtualDevice device(scenes::rough_walk(glm::dvec3(-50), glm::dvec3(50), 1.0, 100001, 3), {});
  ASSERT_FALSE(device.open().has_value());
  Ring<ServoRecord> ring(1 << 20);
  volume::RemovalEditor editor(std::make_shared<volume::Version>(scene.base), {scene.items[0].field});
  Histogram histogram;
  long contacts = 0;
  Pose pose;
  for (int i = 0; i < 100000; ++i) {
    if (i % 5000 == 0) {  // work of the edit thread, not watched
      editor.remove({pose.position_world, pose.position_world, 4});
      const TouchState now(editor.publish());
      for (ServoHand& hand : next.hands) hand.state = now;
      channel.publish(std::make_shared<ServoScene>(next));
    }
    is_watched = true;
    const ServoScene* seen = channel.adopt(reader);
    device.read(i * 1e-3, pose);
    for (ServoCore& core : cores) {
      const ServoRecord record = core.step(*seen, {pose});
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
  // Planted faults: two calls of the allocator and one lock are counted.
  is_watched = true;
  void* volatile seen = std::malloc(10);  // volatile, since compilers may drop a malloc that is freed
  std::free(seen);
  pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
  pthread_mutex_lock(&mutex);
  pthread_mutex_unlock(&mutex);
  is_watched = false;
  EXPECT_EQ(allocations.load(), 2);
  EXPECT_EQ(locks.load(), 1);
}

/// All features of a scene at once: a round tool whose fields follow the cuts, a model, friction and
/// viscosity, effects, the passivity controller, growing matter and the escape path, lost ticks, resets.
TEST(ServoQuiet, RoundToolsModelsEffectsPassivityAndEscapePathsNeitherAllocateNorLock) {
  allocations = locks = 0;
  data_tools::PhantomOptions options;
  options.size = glm::ivec3(96);
  options.psf_sigma_voxels = 1;
  TouchScene scene = scenes::phantom_scene("shell", options);
  scene.items[0].material = {0.5, 0.001, 0.3, 0.2};
  scene.items[0].material.viscosity = 0.001;
  ASSERT_FALSE(set_tool_radius(scene, 2).has_value());
  scene.items.push_back(mesh_item(
      "block", std::make_shared<MeshTree>(
                   std::vector<glm::dvec3>{{-20, -20, -20}, {20, -20, -20}, {0, 20, -20}, {0, 0, 20}},
                   std::vector<std::uint32_t>{0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3})));
  scene.items.back().mover = 0;
  const auto method = make_method("scene").value();
  ASSERT_FALSE(method->prepare(scene).has_value());
  ForceOptions force;
  force.is_passive = true;
  force.delay_ticks = 1;
  ServoCore core(force, 1e-3);
  auto laws = std::make_shared<LawSet>();
  for (const char* effect :
       {"constant force=0,0,-0.1", "viscous damping=0.001", "spring anchor=0,0,40 stiffness=0.01",
        "vibration amplitude=0.05 frequency=120"}) {
    const auto parsed = parse_effect(effect);
    ASSERT_TRUE(parsed) << effect << " " << parsed.error().what;
    ASSERT_FALSE(laws->add(law_of(parsed.value(), static_cast<std::uint32_t>(laws->laws().size())).value())
                     .has_value());
  }
  const auto uncut = std::make_shared<volume::Version>(scene.base);
  volume::RemovalEditor editor(uncut, {scene.items[0].field});
  ServoScene next = scene_for_one(scene, *method, editor.publish(), laws);
  ServoChannel channel(std::make_shared<ServoScene>(next));
  const int reader = channel.open_reader();
  VirtualDevice device(scenes::rough_walk(glm::dvec3(-50), glm::dvec3(50), 1.0, 40001, 3), {});
  ASSERT_FALSE(device.open().has_value());
  Pose pose;
  long contacts = 0, escaping_ticks = 0, mesh_contacts = 0;
  int cut_at = -1, cuts = 0;
  for (int i = 0; i < 40000; ++i) {
    // Cuts at the contact, and undoes each cut sixty ticks later.
    const bool is_cut = cut_at < 0 && cuts < 6 && i > 100 && core.last_step().has_contact,
               is_undo = cut_at >= 0 && i == cut_at + 60;
    if (is_undo || is_cut) {
      cut_at = is_cut ? i : -1;
      cuts += is_cut;
      const glm::dvec3 free = core.proxy_state().proxy_volume;
      TouchState::OffsetFields offsets;
      if (is_undo) {
        editor.reset(uncut);
      } else {
        const glm::dvec3& at = pose.position_world;
        const auto report = editor.remove({at, at, 9});
        offsets.push_back(scene.items[0].offset->updated(scene.items[0].field, *scene.items[0].bits,
                                                         editor.working(), report.box));
      }
      next.hands[0].state = TouchState(editor.publish(), std::move(offsets));
      next.serial = next.hands[0].state.version->serial();
      EscapePath way;
      way.serial = next.serial;
      way.count = 2;
      way.positions_volume[0] = free;
      way.positions_volume[1] = scene.base->frame.volume_from_world(glm::dvec3(0, 0, 58));
      next.hands[0].escape_path = std::make_shared<EscapePath>(way);
    }
    if (i % 20 == 0) next.hands[0].set_placement(0, {glm::dvec3(0, 0, 1e-3 * i), {1, 0, 0, 0}});
    if (i % 1000 == 999) next.hands[0].laws = next.hands[0].laws ? nullptr : laws;
    if (is_undo || is_cut || i % 20 == 0) channel.publish(std::make_shared<ServoScene>(next));
    is_watched = true;
    const ServoScene* seen = channel.adopt(reader);
    device.read(i * 1e-3, pose);
    ServoInput input{pose};
    input.is_reset = i % 9000 == 8999;
    const ServoRecord record = core.step(*seen, input);
    if (i % 7000 == 6999) core.skip(0, 5);
    device.write(record.force_world);
    contacts += record.has_contact, escaping_ticks += record.is_escaping,
        mesh_contacts += record.has_contact && record.shape == 1;
    is_watched = false;
  }
  EXPECT_EQ(allocations.load(), 0);
  EXPECT_EQ(locks.load(), 0);
  EXPECT_GT(contacts, 200);
  EXPECT_GT(mesh_contacts, 0);
  EXPECT_GT(escaping_ticks, 0);
}

/// Counts allocations and locks of the thread that reads it.
class WatchingDevice final : public Device {
 public:
  explicit WatchingDevice(Device& device, long ticks) : device_(&device), ticks_(ticks) {}
  Status open() override { return device_->open(); }
  void close() noexcept override { device_->close(); }
  DeviceCapabilities capabilities() const override { return device_->capabilities(); }
  bool read(double t, Pose& pose) noexcept override {
    const long n = count_.fetch_add(1);
    is_watched = n < ticks_;  // later ticks and the end of the thread are not watched
    return device_->read(t, pose);
  }
  void write(const Wrench& wrench) noexcept override { device_->write(wrench); }
  long count() const { return count_.load(); }

 private:
  Device* device_;
  long ticks_;
  std::atomic<long> count_{0};
};

/// Expects no allocation and no lock while a tool with six degrees of freedom moves through a shell of bone.
void touch_with(const SharedTool& tool) {
  allocations = locks = 0;
  data_tools::PhantomOptions options;
  options.size = glm::ivec3(96);
  options.psf_sigma_voxels = 1;
  TouchScene scene = scenes::phantom_scene("shell", options);
  ASSERT_FALSE(set_tool(scene, tool));
  const auto method = make_method(general_method(*scene.tool).name).value();
  ASSERT_FALSE(method->prepare(scene));
  ServoCore core({}, 1e-3);
  const ServoScene seen = scene_for_one(scene, *method, std::make_shared<volume::Version>(scene.base));
  VirtualDevice device(scenes::rough_walk(glm::dvec3(-50), glm::dvec3(50), 1.0, 20001, 3), {});
  ASSERT_FALSE(device.open());
  Pose pose;
  long contacts = 0;
  for (int i = 0; i < 20000; ++i) {
    device.read(1e-3 * i, pose);
    pose.orientation = {std::cos(0.01 * i), 0, std::sin(0.01 * i), 0};
    is_watched = true;
    const ServoRecord record = core.step(seen, {.pose = pose});
    is_watched = false;
    contacts += record.has_contact;
    device.write(record.wrench());
  }
  EXPECT_GT(contacts, 1000);
  EXPECT_EQ(allocations.load(), 0);
  EXPECT_EQ(locks.load(), 0);
}

TEST(ServoQuiet, ToolOfSeveralBallsNeitherAllocatesNorLocks) {
  const std::vector<glm::dvec3> centres{{-8, 0, 0}, {-4, 0, 0}, {0, 0, 0}, {4, 0, 0}, {8, 0, 0}};
  touch_with(make_tool(2, centres).value());
}

TEST(ServoQuiet, WholeToolNeitherAllocatesNorLocks) {
  touch_with(std::make_shared<const ToolShape>(ToolProfile{{{-2, 2}, {20, 2}}, 1}));
}

TEST(ServoQuiet, DevicesWithMapAndPedalNeitherAllocateNorLock) {
  const auto path = [] {
    return std::make_shared<VirtualDevice>(PosePath::from_samples({{0, {}}, {1, {{9, 0, 0}}}}, "").value(),
                                           HandModel());
  };
  MappedDevice device(std::make_shared<CompositeDevice>(path(), path()), {.scale = 2});
  ASSERT_FALSE(device.open());
  allocations = locks = 0;
  is_watched = true;
  Pose pose;
  for (int i = 0; i < 2000; ++i) {
    if (i % 16 == 0) device.set_view({glm::dvec3(i), glm::dquat(1, 0.001 * i, 0, 0)});
    device.read(0.001 * i, pose);
    device.write(Wrench(glm::dvec3(0, 0, 1)));
  }
  is_watched = false;
  EXPECT_EQ(allocations, 0);
  EXPECT_EQ(locks, 0);
}

TEST(ServoQuiet, ServoLoopNeitherAllocatesNorLocks) {
  allocations = locks = 0;
  data_tools::PhantomOptions options;
  options.size = glm::ivec3(64);
  options.psf_sigma_voxels = 1;
  const TouchScene scene = scenes::phantom_scene("shell", options);
  volume::RemovalEditor editor(std::make_shared<volume::Version>(scene.base), {scene.items[0].field});
  const auto method = make_method(k_default_method).value();
  ASSERT_FALSE(method->prepare(scene).has_value());
  const auto seen = [&] {
    return std::make_shared<ServoScene>(scene_for_one(scene, *method, editor.publish()));
  };
  ServoChannel channel(seen());
  VirtualDevice hand(scenes::rough_walk(glm::dvec3(-50), glm::dvec3(50), 1.0, 60001, 3), {});
  constexpr long k_ticks = 3000;
  WatchingDevice device(hand, k_ticks);
  ServoOptions servo;
  servo.rate_hz = 2000;
  ServoLoop loop(device, channel, servo);
  ASSERT_FALSE(loop.start().has_value());
  ServoRecord record;
  long records = 0;
  // Work of the edit thread, during at most about twenty seconds.
  for (int i = 0; i < 4000 && device.count() < k_ticks; ++i) {
    while (loop.records().pop(record)) ++records;
    if (i % 20 == 5) {
      editor.remove({record.proxy_world, record.proxy_world, 3});
      channel.publish(seen());
    }
    if (i % 50 == 7) loop.request_restart(scene.base->frame.volume_from_world(glm::dvec3(0, 0, 58)));
    if (i % 60 == 9) loop.request_reset();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  loop.stop();
  EXPECT_GE(device.count(), k_ticks);
  EXPECT_GT(records, k_ticks / 2);
  EXPECT_EQ(allocations.load(), 0);
  EXPECT_EQ(locks.load(), 0);
}

}  // namespace
}  // namespace trephine::haptics
