#include "sim/session/session_writer.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "haptics/servo/servo_loop.h"
#include "sim/session/compression.h"

namespace trephine::sim {

namespace {

Error disk_error(const char* what, const std::string& where, int number) {
  Error error{what,
              where,
              std::strerror(number),
              "a writable folder with enough free space",
              "",
              ErrorKind::missing_here};
  if (number == ENOSPC)
    error.remedy = "free disk space, or record to another disk; the part recorded so far is kept";
  if (number == EROFS || number == EACCES) error.remedy = "record to a folder with write permission";
  return error;
}

std::string name_of(const std::string& path) { return path.substr(path.find_last_of('/') + 1); }

/// Syncs the folder of a file. Otherwise a power cut may lose the file's name.
void sync_folder(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  const std::string folder = slash == std::string::npos ? "." : slash == 0 ? "/" : path.substr(0, slash);
  if (const int f = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); f >= 0) {
    ::fsync(f);
    ::close(f);
  }
}

}  // namespace

SessionWriter::SessionWriter(int file, std::string path, TypeList types, const WriterOptions& options)
    : file_(file),
      path_(std::move(path)),
      where_(name_of(path_)),
      options_(options),
      items_(std::move(types)) {}

Result<std::unique_ptr<SessionWriter>> SessionWriter::create(const std::string& path, SessionHeader header,
                                                             const SceneData& data,
                                                             const Catalogue& catalogue,
                                                             const WriterOptions& options) {
  if (Status error = catalogue.check()) return *error;
  describe(catalogue, header);
  const std::string where = name_of(path), header_text = encode(header);
  // Refuses to record a session whose header could not be read again.
  if (const auto readable = decode_header(header_text); !readable)
    return Error{.what = "the session cannot be recorded",
                 .where = where,
                 .found = readable.error().found,
                 .expected = "a value in the range of sessions"};
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (file < 0 && errno == EEXIST)
    return Error{.what = "the file already exists",
                 .where = where,
                 .expected = "a new name for a new session",
                 .remedy = "choose another name, or continue it: trephine resume " + where};
  if (file < 0) return disk_error("the session cannot be recorded", where, errno);
  std::unique_ptr<SessionWriter> writer(new SessionWriter(file, path, types_of(header, catalogue), options));
  ::flock(file, LOCK_EX | LOCK_NB);  // cannot fail: the file is new
  std::string preamble(k_session_magic);
  const std::uint32_t layout[2] = {k_session_layout, 0};
  preamble.append(reinterpret_cast<const char*>(layout), sizeof layout);
  if (::write(file, preamble.data(), preamble.size()) != static_cast<ssize_t>(preamble.size()))
    writer->fail(errno);
  writer->bytes_written_ += preamble.size();
  writer->write_block(BlockKind::header, 0, header_text);
  if (const Status error = writer->status()) {
    writer.reset();
    ::unlink(path.c_str());
    return *error;
  }
  sync_folder(path);
  for (const auto& model : data.models) writer->write_block(BlockKind::model, 0, encode_model(*model));
  for (const auto& stream : data.streams) writer->write_block(BlockKind::stream, 0, encode_stream(*stream));
  writer->volumes_ = data.volumes;
  writer->writer_ = std::thread([w = writer.get()] { w->write_loop(); });
  writer->background_ = std::thread([w = writer.get()] { w->background_loop(); });
  return writer;
}

Result<SessionLock> SessionLock::acquire(const std::string& path) {
  const std::string where = name_of(path);
  const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (file < 0) return disk_error("the session cannot be continued", where, errno);
  SessionLock lock(file, path);
  if (::flock(file, LOCK_EX | LOCK_NB) == 0) return lock;
  return Error{.what = "the session is being recorded",
               .where = where,
               .found = "another trephine writes it",
               .remedy = "close the other program first"};
}

SessionLock::~SessionLock() {
  if (file_ >= 0) ::close(file_);
}

Result<std::unique_ptr<SessionWriter>> SessionWriter::append(SessionLock lock, SessionTail tail,
                                                             const Catalogue& catalogue,
                                                             const WriterOptions& options) {
  const std::string where = name_of(lock.path_);
  for (const ValueType* type : catalogue.all())
    if (!is_of_procedure(*type) && std::find(tail.types.begin(), tail.types.end(), type) == tail.types.end())
      return Error{.what = "the session cannot be continued",
                   .where = where,
                   .found = "a session without " + std::string(type->schema->name),
                   .expected = "a session with all types of this program",
                   .remedy = "continue it with the version that recorded it"};
  const int file = std::exchange(lock.file_, -1);
  std::unique_ptr<SessionWriter> writer(new SessionWriter(file, lock.path_, std::move(tail.types), options));
  if (::ftruncate(file, static_cast<off_t>(tail.length)) != 0 || ::lseek(file, 0, SEEK_END) < 0)
    return disk_error("the session cannot be continued", where, errno);
  writer->bytes_written_ = tail.length;
  writer->next_block_ = tail.blocks;
  writer->is_appended_ = true;
  writer->log_blocks_ = tail.log_blocks;
  writer->tail_ = std::move(tail.checkpoints);
  writer->writer_ = std::thread([w = writer.get()] { w->write_loop(); });
  writer->background_ = std::thread([w = writer.get()] { w->background_loop(); });
  return writer;
}

bool SessionWriter::is_being_written(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return false;
  const bool is_locked = ::flock(file, LOCK_SH | LOCK_NB) != 0;
  ::close(file);
  return is_locked;
}

SessionWriter::~SessionWriter() {
  stop_threads();
  if (file_ >= 0) ::close(file_);
}

void SessionWriter::stop_threads() {
  {
    const std::lock_guard guard(lock_);
    is_stopping_ = true;
  }
  write_wake_.notify_all();
  background_wake_.notify_all();
  if (writer_.joinable()) writer_.join();
  if (background_.joinable()) background_.join();
}

void SessionWriter::begin(const Engine& engine, const haptics::ForceOptions& force, double rate_hz,
                          std::uint64_t first_tick, bool may_wait) {
  ticks_ = first_tick;
  if (options_.checkpoint_work <= 0) return;
  TREPHINE_ASSERT(maker_ == nullptr);  // called once per recording
  maker_ =
      std::make_unique<CheckpointMaker>(engine, force, 1 / rate_hz, first_tick, options_.checkpoint_work);
  may_wait_ = may_wait;
  encoder_ = std::make_unique<CheckpointEncoder>(std::move(tail_), engine.uncut());
}

void SessionWriter::add(const haptics::ServoRecord& record, Engine& engine, const Outcome& outcome) {
  {
    const std::lock_guard guard(lock_);
    items_.add(record);
    last_tick_ = record.tick;
    seal_if_long();
    ticks_ = std::max(ticks_, record.tick + 1);
    // In a continued session, ticks before the first tick of a hand do not count as missing.
    while (next_ticks_.size() <= record.hand)
      next_ticks_.push_back(is_appended_ ? std::nullopt : std::optional<std::uint64_t>(0));
    std::optional<std::uint64_t>& next = next_ticks_[record.hand];
    if (next && record.tick > *next) dropped_ += record.tick - *next;
    next = record.tick + 1;
    record_outcome(engine, outcome);
    if (was_in_stroke_ && !engine.is_in_stroke()) request_sync(engine);
    was_in_stroke_ = engine.is_in_stroke();
  }
  if (!maker_) return;
  maker_->add(record, engine, outcome);
  record_checkpoint(engine);
}

void SessionWriter::add(const Command& command, Engine& engine, const Outcome& outcome) {
  if (outcome.refused && !outcome.is_refusal_recorded) return;
  {
    const std::lock_guard guard(lock_);
    items_.add(CommandItem{command});
    record_outcome(engine, outcome);
    if (!command.request.as<Adopt>()) {
      request_sync(engine);
      was_in_stroke_ = engine.is_in_stroke();
    }
  }
  if (!maker_) return;
  maker_->add(command, engine, outcome);
  record_checkpoint(engine);
}

/// Records new events and the new version, which a replay must reproduce.
void SessionWriter::record_outcome(const Engine& engine, const Outcome& outcome) {
  const Chronicle& chronicle = engine.state().chronicle;
  if (outcome.is_edit) has_edits_ = true;
  for (std::size_t i = chronicle.size() - outcome.event_count; i < chronicle.size(); ++i) {
    items_.add(EventItem{chronicle[i]});
    if (!chronicle[i].value.as<FaultEvent>()) has_edits_ = true;  // faults alone are not worth keeping
  }
  if (!outcome.is_changed) return;
  items_.add(VersionItem{engine.serial(), last_tick_, engine.version()->ledger().total()});
}

void SessionWriter::request_sync(const Engine& engine) {
  wants_sync_ = true;
  if (engine.is_in_stroke() || engine.serial() == hashed_serial_) return;
  hashed_serial_ = engine.serial();
  version_to_hash_ = engine.version();
}

void SessionWriter::seal_if_long() {
  // Bounds the length of a block in a run faster than real time, since damage loses a whole block.
  constexpr std::size_t k_longest = 1 << 13;
  constexpr std::uint64_t k_most_ticks = 1000;  // a tick at rest takes only 5 bytes
  if (items_.size() >= k_longest || last_tick_ >= items_.first_tick() + k_most_ticks) seal();
}

void SessionWriter::seal() {
  if (items_.is_empty()) return;
  const std::uint64_t first_tick = items_.first_tick();
  sealed_.emplace_back(first_tick, items_.fetch_bytes());
  ++log_blocks_;
}

/// Begins a checkpoint, if one is due, at the start of a block of the log. Queues a complete checkpoint for
/// encoding. Work that takes longer than a copy runs without the lock. This is safe, since no other thread
/// adds ticks or commands.
void SessionWriter::record_checkpoint(Engine& engine) {
  if (maker_->is_due())
    if (const std::optional<std::uint64_t> block = block_for_checkpoint()) maker_->begin(engine, *block);
  std::unique_ptr<Checkpoint> done = maker_->fetch_checkpoint();
  if (!done) return;
  const std::lock_guard guard(lock_);
  seal();  // the log up to the current tick must precede the checkpoint in the file
  pending_checkpoints_.push_back(std::move(done));
  background_wake_.notify_one();
}

/// Returns the index of the block of the log that begins here. Empty while too many checkpoints wait to be
/// encoded, and after a failure.
std::optional<std::uint64_t> SessionWriter::block_for_checkpoint() {
  constexpr std::size_t k_max_waiting = 4;  // while the disk does not respond
  const auto has_room = [this] { return pending_checkpoints_.size() < k_max_waiting; };
  std::unique_lock guard(lock_);
  if (may_wait_) encoded_.wait(guard, has_room);
  if (!has_room() || status_) return std::nullopt;
  seal();
  return log_blocks_;
}

/// Encodes in the background: a cut of one second changes many bricks, whose encoding takes long.
void SessionWriter::encode_checkpoints(std::unique_lock<std::mutex>& guard) {
  while (!pending_checkpoints_.empty()) {
    std::unique_ptr<Checkpoint> next = std::move(pending_checkpoints_.front());
    pending_checkpoints_.erase(pending_checkpoints_.begin());
    guard.unlock();
    std::string bytes = encoder_->encode(*next);
    const std::uint64_t tick = next->next_tick;
    next.reset();  // frees versions and fields without the lock
    guard.lock();
    checkpoints_.emplace_back(tick, std::move(bytes));
    encoded_.notify_one();
  }
}

void SessionWriter::write_items(std::unique_lock<std::mutex>& guard) {
  seal();
  const auto blocks = std::exchange(sealed_, {}), checkpoints = std::exchange(checkpoints_, {});
  guard.unlock();
  for (const auto& [first_tick, payload] : blocks) write_block(BlockKind::log, first_tick, compress(payload));
  for (const auto& [tick, payload] : checkpoints) write_block(BlockKind::checkpoint, tick, payload);
  guard.lock();
}

void SessionWriter::write_loop() {
  if (options_.wants_realtime) haptics::request_realtime(50);
  const auto period = std::chrono::duration<double>(options_.block_seconds);
  std::unique_lock guard(lock_);
  for (;;) {
    write_wake_.wait_for(guard, period, [this] { return is_stopping_; });
    const bool is_last = is_stopping_, wants_sync = std::exchange(wants_sync_, false);
    write_items(guard);
    if (wants_sync) {
      is_sync_due_ = true;
      background_wake_.notify_one();
    }
    if (is_last) return;
  }
}

void SessionWriter::background_loop() {
  // Hashes and writes the scan first. This takes a second for a large scan; the operation does not wait for
  // it.
  if (!volumes_.empty()) {
    const std::uint64_t hash = volume::content_hash(*volumes_[0]);
    write_block(BlockKind::scan_hash, 0, std::string(reinterpret_cast<const char*>(&hash), sizeof hash));
    if (options_.is_embedding)
      for (const auto& volume : volumes_) write_block(BlockKind::scan, 0, encode_scan(*volume));
    volumes_.clear();
  }
  using Clock = std::chrono::steady_clock;
  const auto period =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(options_.sync_seconds));
  auto next_sync = Clock::now() + period;
  std::unique_lock guard(lock_);
  for (;;) {
    background_wake_.wait_until(
        guard, next_sync, [this] { return is_stopping_ || is_sync_due_ || !pending_checkpoints_.empty(); });
    encode_checkpoints(guard);
    if (!is_stopping_ && !is_sync_due_ && Clock::now() < next_sync) continue;
    next_sync = Clock::now() + period;
    is_sync_due_ = false;
    const bool is_last = is_stopping_;
    const std::shared_ptr<const volume::Version> version = std::exchange(version_to_hash_, nullptr);
    const std::uint64_t serial = hashed_serial_;
    guard.unlock();
    // A version between strokes is immutable, so this thread may read all of it.
    std::uint64_t hash = 0;
    if (version) hash = version->content_hash();
    if (::fdatasync(file_) != 0) fail(errno);
    ++sync_count_;
    guard.lock();
    if (version) items_.add(HashItem{serial, hash});
    if (is_last) return;
  }
}

void SessionWriter::write_block(BlockKind kind, std::uint64_t first_tick, const std::string& payload) {
  const std::lock_guard guard(file_lock_);
  {
    const std::lock_guard inner(lock_);
    if (status_) return;
  }
  const BlockHead head{k_block_magic, static_cast<std::uint32_t>(kind), next_block_++, first_tick,
                       payload.size()};
  const std::uint64_t check = block_checksum(head, payload);
  std::string bytes(reinterpret_cast<const char*>(&head), sizeof head);
  bytes += payload;
  bytes.append(reinterpret_cast<const char*>(&check), sizeof check);
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t n = ::write(file_, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      const int number = n < 0 ? errno : ENOSPC;
      // Truncates the file to its last whole block, so that it stays readable.
      if (::ftruncate(file_, static_cast<off_t>(bytes_written_.load())) != 0) {}
      return fail(number);
    }
    done += static_cast<std::size_t>(n);
  }
  bytes_written_ += bytes.size();
}

void SessionWriter::fail(int number) {
  const std::lock_guard guard(lock_);
  if (!status_) status_ = disk_error("the recording ended early", where_, number);
}

Status SessionWriter::status() const {
  const std::lock_guard guard(lock_);
  return status_;
}

Status SessionWriter::finish(const Engine& engine) {
  stop_threads();
  if (file_ < 0) return status();
  {
    std::unique_lock guard(lock_);
    write_items(guard);
  }
  const volume::Version& version = *engine.version();
  write_block(BlockKind::end, last_tick_,
              encode(SessionEnd{.ticks = ticks_,
                                .serial = engine.serial(),
                                .dropped = dropped_,
                                .hash = version.content_hash(),
                                .state = engine.state().hash(),
                                .removed_mm3 = engine.removed_mm3(),
                                .measures = engine.measures()}));
  if (::fsync(file_) != 0) fail(errno);
  ::close(std::exchange(file_, -1));
  if (options_.is_removed_when_empty && !has_edits()) ::unlink(path_.c_str());
  return status();
}

}  // namespace trephine::sim
