#include "sim/session/session_reader.h"

#include <cstring>

#include "sim/session/compression.h"

namespace trephine::sim {

Result<SessionReader> SessionReader::open(const std::string& path, const Catalogue& catalogue) {
  SessionReader r;
  r.catalogue_ = catalogue;
  r.where_ = path.substr(path.find_last_of('/') + 1);
  r.file_.open(path, std::ios::binary | std::ios::ate);
  const auto no_session = [&r](const char* found) {
    return Error{.what = "the file is not a session of trephine",
                 .where = r.where_,
                 .found = found,
                 .expected = "a recorded session",
                 .remedy = "choose a recorded session"};
  };
  const std::streamoff end = r.file_ ? static_cast<std::streamoff>(r.file_.tellg()) : -1;
  if (end < 0 || end == std::numeric_limits<std::streamoff>::max())
    return Error{.what = "the session cannot be opened",
                 .where = r.where_,
                 .expected = "a file that can be read",
                 .remedy = "check the spelling"};
  const auto size = static_cast<std::uint64_t>(end);
  r.file_.seekg(0);
  char magic[16] = {};
  if (!r.file_.read(magic, sizeof magic)) return no_session("fewer than 16 bytes");
  if (std::string_view(magic, 8) != k_session_magic) return no_session("another kind of file");
  std::uint32_t layout = 0;
  std::memcpy(&layout, magic + 8, sizeof layout);
  if (layout > k_session_layout)
    return Error{.what = "the session was written by a newer trephine",
                 .where = r.where_,
                 .found = "layout " + std::to_string(layout),
                 .expected = "layout " + std::to_string(k_session_layout),
                 .remedy = "open it with that version"};
  if (layout == 0) return no_session("layout 0");
  if (layout < k_session_layout)
    return Error{.what = "the session was written by an older trephine",
                 .where = r.where_,
                 .found = "layout " + std::to_string(layout),
                 .expected = "layout " + std::to_string(k_session_layout),
                 .remedy = "open it with that version"};

  // Reads block by block, up to the first incomplete one.
  r.complete_bytes_ = sizeof magic;
  bool has_header = false;
  std::string payload;
  while (size - r.complete_bytes_ >= sizeof(BlockHead) + 8) {
    BlockHead head;
    r.file_.seekg(static_cast<std::streamoff>(r.complete_bytes_));
    if (!r.file_.read(reinterpret_cast<char*>(&head), sizeof head)) break;
    const std::uint64_t at = r.complete_bytes_ + sizeof head;
    if (head.magic != k_block_magic || head.number != r.block_count_ || head.length > size - at - 8) break;
    payload.resize(head.length);
    std::uint64_t check = 0;
    if (!r.file_.read(payload.data(), static_cast<std::streamsize>(head.length))) break;
    if (!r.file_.read(reinterpret_cast<char*>(&check), sizeof check)) break;
    if (check != block_checksum(head, payload)) {
      r.is_damaged_ = true;  // the block is whole, so writing was not interrupted
      break;
    }
    switch (static_cast<BlockKind>(head.kind)) {
      case BlockKind::header: {
        Result<SessionHeader> header = decode_header(payload);
        if (!header) return header.error();
        r.header_ = std::move(header).value();
        r.types_ = types_of(r.header_, catalogue);
        has_header = true;
        break;
      }
      case BlockKind::scan_hash: {
        std::uint64_t hash = 0;
        if (has_header && payload.size() == sizeof hash) {
          std::memcpy(&hash, payload.data(), sizeof hash);
          r.scan_hash_ = r.header_.volumes[0].hash = hash;
        }
        break;
      }
      case BlockKind::scan:
        r.scans_.push_back({at, head.length});
        break;
      case BlockKind::model:
        r.models_.push_back({at, head.length});
        break;
      case BlockKind::stream:
        r.streams_.push_back({at, head.length});
        break;
      case BlockKind::log:
        r.logs_.push_back({at, head.length});
        r.end_.reset();  // the session was continued
        break;
      case BlockKind::checkpoint: {
        CheckpointIndex index;
        if (!read_index(payload, index)) break;
        const auto shift = [at](CheckpointIndex::Part& part) { part.at += at; };
        for (CheckpointIndex::Link& link : index.links) shift(link.bytes);
        for (CheckpointIndex::Part* part : {&index.events, &index.trails, &index.history, &index.rest})
          shift(*part);
        if (r.checkpoints_.empty() || index.next_tick > r.checkpoints_.back().next_tick)
          r.checkpoints_.push_back(std::move(index));
        break;
      }
      case BlockKind::end: {
        Result<SessionEnd> last = decode_end(payload);
        if (last) r.end_ = last.value();
        break;
      }
      default:
        break;  // a kind that this program does not need
    }
    r.complete_bytes_ = at + head.length + 8;
    ++r.block_count_;
  }
  if (!has_header) return no_session("its header is incomplete");
  r.file_.clear();
  r.lost_bytes_ = size - r.complete_bytes_;

  // Further heads of blocks mean that the file is damaged in the middle. Otherwise its end is truncated.
  constexpr std::uint64_t k_chunk = 1 << 24;
  for (std::uint64_t at = r.complete_bytes_ + 4; at + 4 <= size && !r.is_damaged_; at += k_chunk) {
    // 3 more bytes, since a head may begin in one chunk and continue in the next.
    std::string rest(static_cast<std::size_t>(std::min(size - at, k_chunk + 3)), '\0');
    r.file_.seekg(static_cast<std::streamoff>(at));
    r.file_.read(rest.data(), static_cast<std::streamsize>(rest.size()));
    r.file_.clear();
    r.is_damaged_ = rest.find("TRPB") != std::string::npos;
  }
  // The newest tick is in the last block of the log that contains ticks.
  for (std::size_t b = r.logs_.size(); b-- > 0 && r.tick_count_ == 0;) {
    Result<std::string> bytes = r.read_packed(r.logs_[b]);
    if (!bytes) return bytes.error();
    ItemDecoder decoder(bytes.value(), r.types_);
    while (!decoder.is_at_end()) {
      Result<LogItem> item = decoder.next();
      if (!item) return item.error();
      if (const auto* tick = std::get_if<TickItem>(&item.value()))
        r.tick_count_ = std::max(r.tick_count_, std::min(tick->record.tick, ~std::uint64_t{1}) + 1);
    }
  }
  return r;
}

Result<std::string> SessionReader::read(const Span& span) {
  std::string bytes(span.length, '\0');
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(span.at));
  if (!file_.read(bytes.data(), static_cast<std::streamsize>(span.length)))
    return Error{.what = "the session is no longer readable",
                 .where = where_,
                 .expected = "a file that is neither moved nor deleted"};
  return bytes;
}

Result<std::string> SessionReader::read_packed(const Span& span) {
  Result<std::string> bytes = read(span);
  return bytes ? decompress(bytes.value()) : std::move(bytes);
}

Result<volume::Volume> SessionReader::scan(std::size_t index) {
  Result<std::string> bytes = read(scans_[index]);
  if (!bytes) return bytes.error();
  return decode_scan(bytes.value());
}

Result<std::vector<std::shared_ptr<const haptics::MeshTree>>> SessionReader::models() {
  std::vector<std::shared_ptr<const haptics::MeshTree>> result;
  for (const Span& span : models_) {
    Result<std::string> bytes = read(span);
    if (!bytes) return bytes.error();
    auto model = decode_model(bytes.value());
    if (!model) return model.error();
    result.push_back(std::move(model).value());
  }
  return result;
}

Result<std::vector<std::shared_ptr<const haptics::depth::DepthStream>>> SessionReader::streams() {
  std::vector<std::shared_ptr<const haptics::depth::DepthStream>> result;
  for (const Span& span : streams_) {
    Result<std::string> bytes = read(span);
    if (!bytes) return bytes.error();
    auto stream = decode_stream(bytes.value());
    if (!stream) return stream.error();
    result.push_back(std::move(stream).value());
  }
  return result;
}

Result<bool> SessionReader::next(LogItem& item) {
  while (!decoder_ || decoder_->is_at_end()) {
    if (decoder_) position_ = {position_.block + 1, 0};
    decoder_.reset();
    if (position_.block >= logs_.size()) return false;
    Result<std::string> bytes = read_packed(logs_[position_.block]);
    if (!bytes) return bytes.error();
    payload_ = std::move(bytes).value();
    decoder_ = std::make_unique<ItemDecoder>(payload_, types_);
  }
  Result<LogItem> read = decoder_->next();
  if (!read) return read.error();
  ++position_.items;
  item = std::move(read).value();
  return true;
}

std::uint64_t SessionReader::log_bytes() const noexcept {
  std::uint64_t sum = 0;
  for (const Span& span : logs_) sum += sizeof(BlockHead) + span.length + sizeof(std::uint64_t);
  return sum;
}

Status SessionReader::go_to(const Position& position) {
  decoder_.reset();
  position_ = {position.block, 0};
  LogItem item;
  while (position_.items < position.items) {
    const Result<bool> read = next(item);
    if (!read) return read.error();
    if (!read.value()) break;
  }
  return std::nullopt;
}

}  // namespace trephine::sim
