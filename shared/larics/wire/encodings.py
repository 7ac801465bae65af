"""The encoder that the setting `output` chooses for measurements and status."""


def measurement_encoder(settings, uptime):
    """None for "larics", else an encoder for Outbox(measurements=...); `uptime` is the Outbox's.

    Modules are loaded only when they are needed: a board has little memory.
    """
    if settings.output == "nmea":
        from larics.wire.nmea import NmeaEncoder

        return NmeaEncoder()
    if settings.output == "mavlink":
        from larics.wire.mavlink import MavlinkEncoder

        return MavlinkEncoder(
            uptime,
            settings.mavlink_system,
            settings.mavlink_component,
            settings.mavlink_target,
            settings.max_speed_mm_s,
        )
    return None
