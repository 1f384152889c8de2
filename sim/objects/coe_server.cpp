#include "sim/objects/coe_server.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace gantry::sim {

using namespace devices::wire;
using config::ObjectAddress;

namespace {
constexpr std::size_t kSdoData = 10;          // ETG.1000.6 table 36: what an SDO mailbox carries at least
constexpr std::size_t kSegmentHeader = 1;     // command byte
constexpr std::size_t kLongestObject = 4096;  // a download announced as longer is refused at once
}  // namespace

void CoeServer::reset() noexcept {
  replies_.clear();
  transfer_ = {};
  last_request_counter_ = reply_counter_ = 0;
}

CoeServer::Bytes CoeServer::next() {
  Bytes mailbox = std::move(replies_.front());
  replies_.pop_front();
  return mailbox;
}

void CoeServer::take(std::span<const std::byte> mailbox, bool pre_op) {
  if (mailbox.size() < kMailboxHeader) return;
  const MailboxHeader header = get_mailbox_header(mailbox);
  if (header.counter != 0 && header.counter == last_request_counter_) return;
  last_request_counter_ = header.counter;
  if (header.length > mailbox.size() - kMailboxHeader) return reply_error(MailboxError::InvalidSize);
  if (header.type != MailboxType::Coe) return reply_error(MailboxError::UnsupportedProtocol);
  if (header.length < kCoeHeader) return reply_error(MailboxError::SizeTooShort);
  const auto payload = mailbox.subspan(kMailboxHeader, header.length);
  const auto service = coe_service(get_le<std::uint16_t>(payload, 0));
  if (service == CoeService::SdoInformation && information_) return serve_information(payload.subspan(kCoeHeader));
  if (service != CoeService::SdoRequest) return reply_error(MailboxError::ServiceNotSupported);
  if (payload.size() < kCoeHeader + kSdoBytes) return reply_error(MailboxError::SizeTooShort);
  serve_sdo(payload.subspan(kCoeHeader), pre_op);
}

void CoeServer::serve_sdo(std::span<const std::byte> bytes, bool pre_op) {
  const SdoHeader h = get_sdo_header(bytes);
  if (lies_.silent_at && *lies_.silent_at == ObjectAddress{h.index, h.sub}) return;
  if (const auto& a = lies_.aborts; a && a->address == ObjectAddress{h.index, h.sub}) {
    const unsigned what = h.command & sdo::kCommandMask;
    if ((what == sdo::kUploadRequest && a->reads) || (what == sdo::kDownloadRequest && a->writes))
      return abort(a->address, a->code);
  }
  switch (h.command & sdo::kCommandMask) {
    case sdo::kUploadRequest: return upload(h);
    case sdo::kDownloadRequest: return download(h, bytes.subspan(kSdoBytes), pre_op);
    case sdo::kUploadSegmentRequest: return upload_segment(h.command);
    case sdo::kDownloadSegmentRequest: return download_segment(h.command, bytes.subspan(kSegmentHeader), pre_op);
    case sdo::kAbort: transfer_ = {}; return;
    default: return abort({h.index, h.sub}, abort_code::kCommand);
  }
}

std::uint32_t CoeServer::read(ObjectAddress address, bool complete, Bytes& data) const {
  if (lies_.shows && lies_.shows->address == address) return data = lies_.shows->bytes, 0;
  return complete ? objects_.read_complete(address, data) : objects_.read(address, data);
}

std::uint32_t CoeServer::write(ObjectAddress address, bool complete, std::span<const std::byte> data, bool pre_op) {
  return complete ? objects_.write_complete(address, data, pre_op) : objects_.write(address, data, pre_op);
}

bool CoeServer::may_be_expedited(const Bytes& data) const noexcept {
  return !data.empty() && data.size() <= 4 && !lies_.never_expedited && !lies_.in_segments;
}

void CoeServer::upload(const SdoHeader& h) {
  const ObjectAddress address{h.index, h.sub};
  const auto complete = static_cast<std::uint8_t>(h.command & sdo::kCompleteAccess);
  transfer_ = {};
  Bytes data;
  if (const auto code = read(address, complete != 0, data); code != 0) return abort(address, code);
  if (may_be_expedited(data)) {
    std::array<std::byte, 4> value{};
    std::copy(data.begin(), data.end(), value.begin());
    const auto command = static_cast<std::uint8_t>(sdo::kUploadResponse | complete | sdo::kExpedited |
                                                   (lies_.no_size ? 0 : sdo::kSizeIndicated) |
                                                   (lies_.no_size ? 0 : sdo::expedited_size_bits(data.size())));
    return reply_sdo({command, h.index, h.sub, get_le<std::uint32_t>(value, 0)}, {});
  }
  const auto size = static_cast<std::uint32_t>(data.size());
  const std::size_t room = reply_bytes_ - kMailboxHeader - kCoeHeader - kSdoBytes;
  const std::size_t now = lies_.in_segments ? 0 : std::min(room, data.size());
  reply_sdo({static_cast<std::uint8_t>(sdo::kUploadResponse | complete | sdo::kSizeIndicated), h.index, h.sub, size},
            std::span(data).first(now));
  if (now < data.size()) {
    transfer_.kind = Transfer::Kind::Upload;
    transfer_.address = address;
    transfer_.data = std::move(data);
    transfer_.done = now;
  }
}

void CoeServer::upload_segment(std::uint8_t command) {
  const ObjectAddress address = transfer_.address;
  if (transfer_.kind != Transfer::Kind::Upload) return abort(address, abort_code::kCommand);
  if (((command & sdo::kToggle) != 0) != transfer_.toggle) return abort(address, abort_code::kToggle);
  const std::size_t room = reply_bytes_ - kMailboxHeader - kCoeHeader - kSegmentHeader;
  const std::size_t now = std::min(room, transfer_.data.size() - transfer_.done);
  const bool last = transfer_.done + now == transfer_.data.size();
  const unsigned toggle = (command & sdo::kToggle) ^ (lies_.wrong_toggle ? sdo::kToggle : 0u);
  reply_segment(static_cast<std::uint8_t>(sdo::kUploadSegmentResponse | toggle | sdo::segment_size_bits(now) |
                                          (last ? sdo::kLastSegment : 0)),
                std::span(transfer_.data).subspan(transfer_.done, now));
  transfer_.done += now;
  transfer_.toggle = !transfer_.toggle;
  if (last) transfer_ = {};
}

void CoeServer::download(const SdoHeader& h, std::span<const std::byte> data, bool pre_op) {
  const ObjectAddress address{h.index, h.sub};
  const bool complete = (h.command & sdo::kCompleteAccess) != 0;
  const SdoHeader done{static_cast<std::uint8_t>(sdo::kDownloadResponse | (h.command & sdo::kCompleteAccess)), h.index,
                       h.sub, 0};
  transfer_ = {};
  if ((h.command & sdo::kExpedited) != 0) {
    std::array<std::byte, 4> value{};
    put_le<std::uint32_t>(value, 0, h.data);
    const std::size_t size = (h.command & sdo::kSizeIndicated) != 0 ? sdo::expedited_size(h.command) : 4;
    if (const auto code = write(address, complete, std::span(value).first(size), pre_op); code != 0)
      return abort(address, code);
    return reply_sdo(done, {});
  }
  const std::size_t size = h.data;
  if (size > kLongestObject) return abort(address, abort_code::kSizeTooLarge);
  if (data.size() >= size) {
    if (const auto code = write(address, complete, data.first(size), pre_op); code != 0) return abort(address, code);
    return reply_sdo(done, {});
  }
  transfer_.kind = Transfer::Kind::Download;
  transfer_.address = address;
  transfer_.complete = complete;
  transfer_.data.assign(data.begin(), data.end());
  transfer_.expected = size;
  reply_sdo(done, {});
}

void CoeServer::download_segment(std::uint8_t command, std::span<const std::byte> data, bool pre_op) {
  const ObjectAddress address = transfer_.address;
  if (transfer_.kind != Transfer::Kind::Download) return abort(address, abort_code::kCommand);
  if (((command & sdo::kToggle) != 0) != transfer_.toggle) return abort(address, abort_code::kToggle);
  // A segment of the shortest mailbox says how many of its seven bytes count; a longer one fills its mailbox.
  const std::size_t size = data.size() <= 7 ? std::min(data.size(), sdo::short_segment_size(command)) : data.size();
  if (transfer_.data.size() + size > transfer_.expected) return abort(address, abort_code::kSizeTooLarge);
  transfer_.data.insert(transfer_.data.end(), data.begin(), data.begin() + static_cast<std::ptrdiff_t>(size));
  transfer_.toggle = !transfer_.toggle;
  if ((command & sdo::kLastSegment) != 0) {
    if (transfer_.data.size() < transfer_.expected) return abort(address, abort_code::kSizeTooSmall);
    if (const auto code = write(address, transfer_.complete, transfer_.data, pre_op); code != 0)
      return abort(address, code);
    transfer_ = {};
  }
  reply_segment(static_cast<std::uint8_t>(sdo::kDownloadSegmentResponse | (command & sdo::kToggle)), {});
}

void CoeServer::emergency(std::uint16_t code, std::uint8_t error_register, std::uint16_t diagnostic) {
  if (!room()) return;  // nobody fetches them
  Bytes payload(kCoeHeader + 8);
  put_le<std::uint16_t>(payload, 0, coe_header(CoeService::Emergency));
  put_le<std::uint16_t>(payload, 2, code);
  put_le<std::uint8_t>(payload, 4, error_register);
  put_le<std::uint16_t>(payload, 5, diagnostic);
  reply(MailboxType::Coe, std::move(payload));
}

void CoeServer::abort(ObjectAddress address, std::uint32_t code) {
  transfer_ = {};
  // Of the request service, as ETG.1000.6 table 42 has it in both directions.
  Bytes payload(kCoeHeader + kSdoBytes);
  put_le<std::uint16_t>(payload, 0, coe_header(CoeService::SdoRequest));
  put_sdo_header(std::span(payload).subspan(kCoeHeader), {abort_command_, address.index, address.sub, code});
  reply(MailboxType::Coe, std::move(payload));
}

void CoeServer::reply_sdo(const SdoHeader& header, std::span<const std::byte> more) {
  Bytes payload(kCoeHeader + kSdoBytes);
  put_le<std::uint16_t>(payload, 0, coe_header(CoeService::SdoResponse));
  put_sdo_header(std::span(payload).subspan(kCoeHeader), header);
  payload.insert(payload.end(), more.begin(), more.end());
  reply(MailboxType::Coe, std::move(payload));
}

void CoeServer::reply_segment(std::uint8_t command, std::span<const std::byte> data) {
  Bytes payload(kCoeHeader + kSegmentHeader);
  put_le<std::uint16_t>(payload, 0, coe_header(CoeService::SdoResponse));
  put_le<std::uint8_t>(payload, kCoeHeader, command);
  payload.insert(payload.end(), data.begin(), data.end());
  payload.resize(std::max(payload.size(), kSdoData));
  reply(MailboxType::Coe, std::move(payload));
}

void CoeServer::reply_error(MailboxError error) {
  Bytes payload(4);
  put_le<std::uint16_t>(payload, 0, 1);  // ETG.1000.4 table 30: type 1, error reply
  put_le<std::uint16_t>(payload, 2, static_cast<std::uint16_t>(error));
  reply(MailboxType::Error, std::move(payload));
}

void CoeServer::reply(MailboxType type, Bytes payload) {
  const bool is_emergency = type == MailboxType::Coe && payload.size() >= kCoeHeader &&
                            coe_service(get_le<std::uint16_t>(payload, 0)) == CoeService::Emergency;
  if (lies_.emergency_first && !is_emergency) emergency(0x8130, 0x11);
  reply_counter_ = next_counter(reply_counter_);
  queue(type, payload);
  if (lies_.twice == MailboxLies::Twice::No || is_emergency) return;
  if (lies_.twice == MailboxLies::Twice::NewCounter) reply_counter_ = next_counter(reply_counter_);
  queue(type, payload);
}

void CoeServer::queue(MailboxType type, const Bytes& payload) {
  Bytes mailbox(kMailboxHeader);
  put_mailbox_header(mailbox,
                     {static_cast<std::uint16_t>(payload.size()), 0, 0, type, lies_.counter.value_or(reply_counter_)});
  mailbox.insert(mailbox.end(), payload.begin(), payload.end());
  replies_.push_back(std::move(mailbox));
}

}  // namespace gantry::sim
