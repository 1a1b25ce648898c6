"""Certificates of stability: what theory proves, under which assumptions, up to which delay."""

from scara_drake.stability.certificates.krasovskii import proven_delay
from scara_drake.stability.certificates.loop import Loop, seen_delay
from scara_drake.stability.certificates.of_scenario import certify, colgate_bound
from scara_drake.stability.certificates.result import Certificate, Certificates, Seen
from scara_drake.stability.certificates.small_gain import bears_any_delay, varying_delay
from scara_drake.stability.certificates.two_port import absolute_delay, llewellyn

__all__ = [
    "Certificate",
    "Certificates",
    "Loop",
    "Seen",
    "absolute_delay",
    "bears_any_delay",
    "certify",
    "colgate_bound",
    "llewellyn",
    "proven_delay",
    "seen_delay",
    "varying_delay",
]
